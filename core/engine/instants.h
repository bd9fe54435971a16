#pragma once

#include <deque>
#include <set>

#include "core/engine/requests.h"
#include "core/engine/rig_state.h"
#include "core/engine/world_desk.h"

namespace camrig::engine {

/// Brings about what falls due: in real time as the clock runs, else by steps. An instant begins with a snapshot of the
/// world and where its cameras are; what is drawn of it goes out, what is not goes to the books. Engine's thread.
class Instants {
public:
    Instants(RigState& rig, WorldDesk& world, Requests& requests) : rig_(rig), world_(world), requests_(requests) {}
    /// Answers who still waits for a step.
    ~Instants();

    /// What is due at monotonic_ns: some ms of the world's steps, or an instant.
    void turn(TimeNs monotonic_ns);
    /// Whether it was started; else the request is answered.
    bool start_step(Request<StepWorld>& request, std::function<WorldState()> state);
    /// All is done that comes before a command of that world time, and the time has come.
    bool has_reached(TimeNs world_ns, TimeNs monotonic_ns) const;
    bool has_steps() const { return !steps_.empty(); }
    /// There is another world, of time 0.
    void begin_world();
    /// When turn() has something to do, if nothing else happens (CLOCK_MONOTONIC).
    TimeNs wake_time_ns() const;

    /// DrawDesk::Callbacks.
    void drawn(DrawnViews& drawn);
    void dropped(const DueViews& due, const render::View& view, stream::DropReason reason);

    /// Its part of stats.get: instants and the times of stages.
    void fill_report(stream::RigReport& report) const;

private:
    struct StepJob {
        TimeNs target_ns = 0;
        TimeNs timeout_ns = 0;
        TimeNs deadline_ns = 0;                        ///< for the delivery in progress
        std::shared_ptr<stream::DeliveryLatch> latch;  ///< of the instant published last
        std::optional<frame::FrameSet>
            next;  ///< what is drawn of the next instant; to be published when the latch is open
        std::function<void(Result<WorldState>)> done;
        std::function<WorldState()> state;
    };

    void run_realtime(TimeNs monotonic_ns);
    void advance_step(TimeNs monotonic_ns);
    void give_up_step(TimeNs monotonic_ns);
    /// The world, which is there, at this instant; what is wanted of it is handed to be drawn.
    void begin_instant(TimeNs world_ns, TimeNs monotonic_ns, bool may_be_dropped);
    void account_skipped(TimeNs instant_ns);
    /// A frame that was wanted does not go out.
    void miss(CameraEntry& entry, TimeNs world_ns, stream::DropReason reason);
    /// What is drawn knows what differs from what was drawn before; of pictures that went out otherwise it is not true.
    static void forget_damage(CameraEntry& entry, const render::View& view, std::span<frame::FrameRef> frames);

    RigState& rig_;
    WorldDesk& world_;
    Requests& requests_;
    /// In real time: how late the next instant was when it was chosen, which then waits for the world's steps to reach
    /// it; nullopt: none is chosen.
    std::optional<TimeNs> chosen_late_ns_;
    std::deque<StepJob> steps_;
    std::uint64_t instants_ = 0, dropped_instants_ = 0;
    std::set<TimeNs> dropped_at_;  ///< the last instants of which pictures were dropped
    stream::StageTimer wakeup_time_, world_time_;
};

}  // namespace camrig::engine
