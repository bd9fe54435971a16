#pragma once

#include <deque>
#include <list>

#include "core/engine/rig_state.h"

namespace camrig::engine {

/// Advances the world, and carries out the commands on its actors, objects and events. Engine's thread.
class WorldDesk {
public:
    explicit WorldDesk(RigState& rig) : rig_(rig) {}
    /// Fails all requests that still wait.
    ~WorldDesk();

    Result<ActorList> run(ListActors& command);
    Result<ActorChange> run(SpawnActor& command);
    Result<Applied> run(RemoveActor& command);
    Result<ActorChange> run(SetActor& command);
    Result<Applied> run(SteerActors& command);
    Result<ObjectChange> run(SpawnObject& command);
    Result<ObjectChange> run(SetObject& command);
    Result<Applied> run(RemoveObject& command);
    Result<std::vector<world::EventReport>> run(ListEvents& command);
    Result<EventChange> run(AddEvent& command);
    Result<Applied> run(Act& command);
    Result<Applied> run(RemoveEvent& command);
    /// Keeps the request until answer_waits() can answer it.
    void wait_events(Request<WaitEvents>& request);
    /// Answers the requests for which an event has fired or whose time is over.
    void answer_waits(TimeNs monotonic_ns);
    /// When answer_waits() has to be called next (CLOCK_MONOTONIC).
    TimeNs next_deadline_ns() const;

    /// Runs the world's steps up to `world_ns`, for some ms at most. False: more calls are needed, between which other
    /// commands are served.
    bool advance(TimeNs world_ns);
    /// Whether the last advance() did not reach its time.
    bool is_behind() const { return is_behind_; }
    /// Gives up the time that the last advance() did not reach.
    void rest() { is_behind_ = false; }
    /// Wall time spent on steps since the last call.
    TimeNs take_spent_ns() { return std::exchange(spent_ns_, 0); }
    /// The world, advanced to RigState::world_now_ns(); commands act on it.
    world::World& world_of_now();
    /// There is another world now.
    void begin_world();

private:
    /// Takes events and changes of cameras from the world since the last call.
    void collect();
    /// Carries out what events change of cameras up to `world_ns`.
    void move_cameras(TimeNs world_ns);
    Result<void> apply(const world::CameraAction& action, CameraEntry& entry, TimeNs begin_ns);
    Result<void> apply(const world::FaultAction& action, CameraEntry& entry, TimeNs begin_ns);
    Result<void> apply(const world::ClearFaultAction& action, CameraEntry& entry, TimeNs begin_ns);
    EventLog events_since(std::uint64_t since) const;

    struct PendingWait {
        std::uint64_t since = 0;
        TimeNs asked_ns = 0, deadline_ns = 0;
        std::function<void(Result<EventLog>)> done;
    };

    RigState& rig_;
    bool is_behind_ = false;
    TimeNs spent_ns_ = 0;
    std::list<PendingWait> waits_;
    std::deque<world::EventRecord> event_log_;  ///< the newest, in order
    std::uint64_t last_event_ = 0;
    std::uint64_t event_base_ = 0;  ///< number of events of earlier worlds, to which this one's numbers are added
};

}  // namespace camrig::engine
