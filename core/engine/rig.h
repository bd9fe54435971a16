#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/base/thread_check.h"
#include "core/engine/camera_desk.h"
#include "core/engine/fault_desk.h"
#include "core/engine/instants.h"
#include "core/engine/replica_desk.h"
#include "core/engine/requests.h"
#include "core/engine/rig_state.h"
#include "core/engine/world_desk.h"

namespace camrig::engine {

/// World, cameras, schedule and drawing put together: takes commands to the desk that does them, and gives each its
/// turn.
///
/// Thread: the engine's, for every call. Time enters as an argument or from the one monotonic clock; `wake` may be
/// called from other threads when a delivery or a picture is complete, and asks for another tick().
class Rig {
public:
    /// One lane or two (DrawDesk), whose drawn tasks come back through `finished`. Returns when the cameras of the
    /// scene have been drawn once.
    static Result<std::unique_ptr<Rig>> create(world::SceneRef scene, const EngineOptions& options,
                                               std::vector<std::unique_ptr<DrawLane>> lanes,
                                               std::shared_ptr<DrawnTasks> finished, stream::LocalFrameBus& bus,
                                               std::function<void()> wake);

    ~Rig();

    void apply(Command& command);
    void fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done);

    /// A turn of everything: hears what was drawn, does what is due at monotonic_ns, hands out what is to be drawn.
    void tick(TimeNs monotonic_ns);
    /// When tick() has to be called next, if nothing else happens (CLOCK_MONOTONIC).
    TimeNs wake_time_ns() const;

private:
    Rig(const EngineOptions& options, std::vector<std::unique_ptr<DrawLane>> lanes,
        std::shared_ptr<DrawnTasks> finished, stream::LocalFrameBus& bus, std::function<void()> wake);

    /// Whether it is to be done now. Else it waits for its time, or is answered.
    template <typename C>
    bool admit(Request<C>& request, Command& command);
    /// Does it, now or at the time it says.
    void perform(Command& command);
    void do_what_has_its_time(TimeNs monotonic_ns);
    /// The world time of a command that says none, as a log can say it: steps of the world and frames that came before
    /// it come before it again.
    TimeNs time_of_command() const;

    Result<WorldState> run(LoadWorld& command);
    Result<WorldState> run(GetWorld& command);
    Result<std::shared_ptr<const HeldInstant>> run(GetInstant& command);
    Result<WorldState> run(PauseWorld& command);
    Result<WorldState> run(ResumeWorld& command);
    Result<stream::RigReport> run(GetStats& command);
    Result<void> load(world::SceneRef scene);
    WorldState world_state() const;

    ThreadCheck thread_;
    std::int64_t last_held_ = -1;  ///< HeldInstant::sequence
    RigState state_;
    WorldDesk world_;
    CameraDesk cameras_;
    FaultDesk faults_;
    ReplicaDesk replicas_;
    Requests requests_;
    Instants instants_;
};

}  // namespace camrig::engine
