#include <algorithm>

#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "core/engine/rig.h"

// Commands on actors and events, and what events do outside of the world.
namespace camrig {
namespace {

constexpr std::size_t max_event_log = 1024;
constexpr std::size_t max_pending_waits = 256;

}  // namespace

World& Rig::world_of_now() {
    const TimeNs now_ns = world_now_ns(monotonic_now_ns());
    world_->advance_to(now_ns);
    collect_world();
    return *world_;
}

Result<ActorList> Rig::run(ListActors&) {
    const World& world = world_of_now();
    return ActorList{world.actors(), world.state_hash()};
}

Result<ActorChange> Rig::run(SpawnActor& command) {
    World& world = world_of_now();
    auto actor = world.spawn_actor(command.actor);
    if (!actor) return std::unexpected(actor.error());
    return ActorChange{std::move(*actor), world.last_step_ns()};
}

Result<Applied> Rig::run(RemoveActor& command) {
    World& world = world_of_now();
    if (auto done = world.remove_actor(command.name); !done) return std::unexpected(done.error());
    return Applied{world.last_step_ns()};
}

Result<ActorChange> Rig::run(SetActor& command) {
    World& world = world_of_now();
    auto actor = world.change_actor(command.patch);
    if (!actor) return std::unexpected(actor.error());
    return ActorChange{std::move(*actor), world.last_step_ns()};
}

Result<Applied> Rig::run(SteerActors& command) {
    World& world = world_of_now();
    if (auto done = world.steer_actors(command.actors); !done) return std::unexpected(done.error());
    return Applied{world.last_step_ns()};
}

Result<std::vector<EventReport>> Rig::run(ListEvents&) {
    return world_of_now().events();
}

Result<EventChange> Rig::run(AddEvent& command) {
    World& world = world_of_now();
    auto event = world.add_event(command.event);
    if (!event) return std::unexpected(event.error());
    return EventChange{std::move(*event), world.last_step_ns()};
}

Result<Applied> Rig::run(RemoveEvent& command) {
    World& world = world_of_now();
    if (auto done = world.remove_event(command.name); !done) return std::unexpected(done.error());
    return Applied{world.last_step_ns()};
}

void Rig::wait_events(Request<WaitEvents>& request) {
    collect_world();
    const WaitEvents& wait = request.command;
    if (last_event_ > wait.since || wait.timeout_ns == 0) return request.done(events_since(wait.since));
    if (waits_.size() >= max_pending_waits)
        return request.done(error(ErrorKind::resource_exhausted, "too many clients wait for events; ask again later"));
    waits_.push_back({wait.since, monotonic_now_ns() + wait.timeout_ns, std::move(request.done)});
}

EventLog Rig::events_since(std::uint64_t since) const {
    EventLog log;
    log.last = last_event_;
    for (const EventRecord& record : event_log_)
        if (record.sequence > since) log.events.push_back(record);
    if (last_event_ > since) log.missed = last_event_ - since - log.events.size();
    return log;
}

void Rig::answer_waits(TimeNs monotonic_ns) {
    for (auto it = waits_.begin(); it != waits_.end();) {
        if (last_event_ <= it->since && monotonic_ns < it->deadline_ns) {
            ++it;
            continue;
        }
        PendingWait wait = std::move(*it);
        it = waits_.erase(it);
        wait.done(events_since(wait.since));
    }
}

void Rig::collect_world() {
    for (EventRecord& record : world_->take_records()) {
        last_event_ = record.sequence += event_base_;
        for (const std::string& problem : record.errors) spdlog::warn("event {}: {}", record.event, problem);
        event_log_.push_back(std::move(record));
        if (event_log_.size() > max_event_log) event_log_.pop_front();
    }
    for (CameraMove& move : world_->take_camera_moves()) camera_moves_.push_back(std::move(move));
}

void Rig::move_cameras(TimeNs world_ns) {
    std::size_t done = 0;
    for (; done < camera_moves_.size() && camera_moves_[done].world_ns <= world_ns; ++done) {
        const CameraMove& move = camera_moves_[done];
        auto entry = cameras_.find(move.camera);
        if (!entry) {
            spdlog::warn("an event moves camera {}, which is not there", move.camera);
            continue;
        }
        CameraSpec spec = *(*entry)->spec;
        spec.pose = move.pose;
        if (auto replaced = cameras_.replace(move.camera, std::move(spec)); !replaced)
            spdlog::warn("an event moves camera {}: {}", move.camera, replaced.error().message);
    }
    camera_moves_.erase(camera_moves_.begin(), camera_moves_.begin() + static_cast<std::ptrdiff_t>(done));
}

}  // namespace camrig
