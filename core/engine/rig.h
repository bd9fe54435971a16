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

/// The engine's parts put together: passes each command to the desk that carries it out, and gives every desk its turn.
///
/// Thread: the engine's, for every call. Time is an argument, or read from CLOCK_MONOTONIC. The rig calls `wake`, from
/// any thread, when a delivery or a picture is complete: tick() is to be called again.
class Rig {
public:
    /// One lane or two (DrawDesk), whose drawn tasks come back through `finished`. Returns when the cameras of the
    /// scene have been drawn once.
    static Result<std::unique_ptr<Rig>> create(world::SceneRef scene, const EngineOptions& options,
                                               std::vector<std::unique_ptr<DrawLane>> lanes,
                                               std::shared_ptr<DrawnTasks> finished, stream::LocalFrameBus& bus,
                                               std::function<void()> wake);

    ~Rig();

    /// Carries the command out, or keeps it until its world time (Request::at_ns).
    void apply(Command& command);
    /// Answers a request for a picture (stream::FrameFetcher), now or later.
    void fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done);

    /// One turn of every desk: takes what was drawn, does what is due at monotonic_ns, hands out what is to be drawn.
    void tick(TimeNs monotonic_ns);
    /// When tick() has to be called next, if nothing else happens (CLOCK_MONOTONIC).
    TimeNs wake_time_ns() const;

private:
    Rig(const EngineOptions& options, std::vector<std::unique_ptr<DrawLane>> lanes,
        std::shared_ptr<DrawnTasks> finished, stream::LocalFrameBus& bus, std::function<void()> wake);

    /// Whether the command is to be carried out now. Else it was moved to the agenda, or answered with an error.
    template <typename C>
    bool admit(Request<C>& request, Command& command);
    /// Carries the command out now.
    void perform(Command& command);
    /// For the digest of what was done, and the log.
    void note(TimeNs at_ns, const std::string& text, bool has_failed);
    /// Carries out the commands of the agenda whose time has come.
    void do_what_has_its_time(TimeNs monotonic_ns);
    /// The world time to log for a command that was given none: carried out at it in a replay, it comes after the same
    /// steps of the world and the same frames.
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
