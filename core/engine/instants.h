#pragma once

#include <deque>
#include <set>

#include "core/engine/requests.h"
#include "core/engine/rig_state.h"
#include "core/engine/world_desk.h"

namespace camrig::engine {

/// Runs the instants at which cameras are due: as the clock runs in real time, by steps in lockstep. Begins each with a
/// snapshot of the world and the due views, publishes what is drawn of it, and counts what is not. Engine's thread.
class Instants {
public:
    Instants(RigState& rig, WorldDesk& world, Requests& requests) : rig_(rig), world_(world), requests_(requests) {}
    /// Fails all requests for steps that still wait.
    ~Instants();

    /// Does what is due at monotonic_ns: some ms of the world's steps, or one instant.
    void turn(TimeNs monotonic_ns);
    /// Queues a step of lockstep; `state` makes its reply. False: the request was refused, and is answered.
    bool start_step(Request<StepWorld>& request, std::function<WorldState()> state);
    /// Whether a command of that world time is to be carried out now: everything that comes before it is done.
    bool has_reached(TimeNs world_ns, TimeNs monotonic_ns) const;
    bool has_steps() const { return !steps_.empty(); }
    /// There is another world, whose time begins at 0.
    void begin_world();
    /// When turn() has to be called next, if nothing else happens (CLOCK_MONOTONIC).
    TimeNs wake_time_ns() const;

    /// DrawDesk::Callbacks.
    void drawn(DrawnViews& drawn);
    void dropped(const DueViews& due, const render::View& view, stream::DropReason reason);

    /// Fills in its part of the reply to stats.get: counts of instants, and the times of stages.
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
    /// Takes the snapshot of this instant, which the world has reached, and hands its wanted views to the DrawDesk.
    void begin_instant(TimeNs world_ns, TimeNs monotonic_ns, bool may_be_dropped);
    void account_skipped(TimeNs instant_ns);
    /// Counts a wanted frame that is not published.
    void miss(CameraEntry& entry, TimeNs world_ns, stream::DropReason reason);
    /// Clears FrameInfo::damage where it refers to a frame that faults changed after drawing.
    static void forget_damage(CameraEntry& entry, const render::View& view, std::span<frame::FrameRef> frames);

    RigState& rig_;
    WorldDesk& world_;
    Requests& requests_;
    /// In real time: how late the next instant was when it was chosen, which then waits for the world's steps to reach
    /// it; nullopt: none is chosen.
    std::optional<TimeNs> chosen_late_ns_;
    std::deque<StepJob> steps_;
    std::uint64_t instants_ = 0, dropped_instants_ = 0;
    std::set<TimeNs> dropped_at_;  ///< recent instants with dropped pictures, each counted once
    stream::StageTimer wakeup_time_, world_time_;
};

}  // namespace camrig::engine
