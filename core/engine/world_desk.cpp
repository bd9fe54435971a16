#include "core/engine/world_desk.h"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "core/world/camera_future.h"

namespace camrig::engine {
namespace {

constexpr std::size_t max_event_log = 1024;
constexpr std::size_t max_pending_waits = 256;
/// So long a wait is its client's own: clients too many that all ask again at once would keep each other busy.
constexpr TimeNs least_wait_ns = ns_per_s;
/// For so long the world makes steps before commands have their turn; one step may take longer.
constexpr TimeNs steps_turn_ns = 5 * ns_per_ms;

}  // namespace

WorldDesk::~WorldDesk() {
    for (auto& wait : waits_) wait.done(error(ErrorKind::unavailable, "the rig shuts down"));
}

bool WorldDesk::advance(TimeNs world_ns) {
    const TimeNs start_ns = monotonic_now_ns();
    TimeNs end_ns = start_ns;
    world::World& world = *rig_.world;
    while (world.last_step_ns() < world_ns && end_ns - start_ns < steps_turn_ns) {
        world.advance_to(std::min(world_ns, world.last_step_ns() + rig_.scene->step_ns));
        end_ns = monotonic_now_ns();
    }
    spent_ns_ += end_ns - start_ns;
    collect();
    move_cameras(std::min(world_ns, world.last_step_ns()));
    is_behind_ = world.last_step_ns() < world_ns;
    return !is_behind_;
}

void WorldDesk::begin_world() {
    is_behind_ = false;
    rig_.camera_moves.clear();
    event_base_ = last_event_;
    collect();
}

world::World& WorldDesk::world_of_now() {
    const TimeNs now_ns = rig_.world_now_ns(monotonic_now_ns());
    rig_.world->advance_to(now_ns);
    collect();
    move_cameras(now_ns);
    return *rig_.world;
}

Result<ActorList> WorldDesk::run(ListActors&) {
    const world::World& world = world_of_now();
    return ActorList{world.actors(), world.state_hash()};
}

Result<ActorChange> WorldDesk::run(SpawnActor& command) {
    world::World& world = world_of_now();
    auto actor = world.spawn_actor(command.actor);
    if (!actor) return std::unexpected(actor.error());
    return ActorChange{std::move(*actor), world.last_step_ns()};
}

Result<Applied> WorldDesk::run(RemoveActor& command) {
    world::World& world = world_of_now();
    if (auto done = world.remove_actor(command.name); !done) return std::unexpected(done.error());
    return Applied{world.last_step_ns()};
}

Result<ActorChange> WorldDesk::run(SetActor& command) {
    world::World& world = world_of_now();
    auto actor = world.change_actor(command.patch);
    if (!actor) return std::unexpected(actor.error());
    return ActorChange{std::move(*actor), world.last_step_ns()};
}

Result<Applied> WorldDesk::run(SteerActors& command) {
    world::World& world = world_of_now();
    if (auto done = world.steer_actors(command.actors); !done) return std::unexpected(done.error());
    return Applied{world.last_step_ns()};
}

namespace {

ObjectChange change_of(const world::World& world, const std::string& name) {
    ObjectChange change{.report = {}, .applied_ns = world.last_step_ns()};
    find_object(*world.snapshot(change.applied_ns), name, &change.report);
    return change;
}

}  // namespace

Result<ObjectChange> WorldDesk::run(SpawnObject& command) {
    world::World& world = world_of_now();
    if (auto done = world.spawn_object(command.object); !done) return std::unexpected(done.error());
    return change_of(world, command.object.name);
}

Result<ObjectChange> WorldDesk::run(SetObject& command) {
    world::World& world = world_of_now();
    if (auto done = world.change_object(command.patch); !done) return std::unexpected(done.error());
    return change_of(world, command.patch.name);
}

Result<Applied> WorldDesk::run(RemoveObject& command) {
    world::World& world = world_of_now();
    if (auto done = world.remove_object(command.name); !done) return std::unexpected(done.error());
    return Applied{world.last_step_ns()};
}

Result<std::vector<world::EventReport>> WorldDesk::run(ListEvents&) {
    return world_of_now().events();
}

Result<EventChange> WorldDesk::run(AddEvent& command) {
    world::World& world = world_of_now();
    auto event = world.add_event(command.event);
    if (!event) return std::unexpected(event.error());
    return EventChange{std::move(*event), world.last_step_ns()};
}

Result<Applied> WorldDesk::run(RemoveEvent& command) {
    world::World& world = world_of_now();
    if (auto done = world.remove_event(command.name); !done) return std::unexpected(done.error());
    return Applied{world.last_step_ns()};
}

Result<Applied> WorldDesk::run(Act& command) {
    world::World& world = world_of_now();
    const auto done = world.act(command.actions);
    // At once, also where the world stands: who waits for events is woken, and cameras have what was done to them. Of
    // actions of which one failed those before it are done.
    collect();
    move_cameras(rig_.world_now_ns(monotonic_now_ns()));
    if (!done) return std::unexpected(done.error());
    return Applied{world.last_step_ns()};
}

void WorldDesk::wait_events(Request<WaitEvents>& request) {
    collect();
    const WaitEvents& wait = request.command;
    if (last_event_ > wait.since || wait.timeout_ns == 0) return request.done(events_since(wait.since));
    const TimeNs now_ns = monotonic_now_ns();
    // Whoever waits longest may be gone; one who is not asks again.
    if (waits_.size() >= max_pending_waits) {
        if (now_ns < waits_.front().asked_ns + least_wait_ns)
            return request.done(
                error(ErrorKind::resource_exhausted, "too many clients wait for events; ask again later"));
        const PendingWait oldest = std::move(waits_.front());
        waits_.pop_front();
        oldest.done(events_since(oldest.since));
    }
    waits_.push_back({wait.since, now_ns, now_ns + wait.timeout_ns, std::move(request.done)});
}

EventLog WorldDesk::events_since(std::uint64_t since) const {
    EventLog log;
    log.last = last_event_;
    for (const world::EventRecord& record : event_log_)
        if (record.sequence > since) log.events.push_back(record);
    if (last_event_ > since) log.missed = last_event_ - since - log.events.size();
    return log;
}

void WorldDesk::answer_waits(TimeNs monotonic_ns) {
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

TimeNs WorldDesk::next_deadline_ns() const {
    TimeNs next_ns = max_time_ns;
    for (const auto& wait : waits_) next_ns = std::min(next_ns, wait.deadline_ns);
    return next_ns;
}

void WorldDesk::collect() {
    for (world::EventRecord& record : rig_.world->take_records()) {
        last_event_ = record.sequence += event_base_;
        for (const std::string& problem : record.errors) spdlog::warn("event {}: {}", record.event, problem);
        event_log_.push_back(std::move(record));
        if (event_log_.size() > max_event_log) event_log_.pop_front();
    }
    for (world::CameraMove& move : rig_.world->take_camera_moves()) rig_.camera_moves.push_back(std::move(move));
    for (const world::Departure& departure : rig_.world->take_departures()) {
        for (auto& [id, entry] : rig_.cameras.all()) {
            const std::optional<world::Mount>& mount = entry.spec().mount;
            if (mount && mount->actor == departure.instance.info->name)
                entry.camera.leave(departure.instance, departure.world_ns);
        }
    }
}

Result<void> WorldDesk::apply(const world::CameraAction& action, CameraEntry& entry, TimeNs begin_ns) {
    auto camera = world::moved(entry.camera, action, begin_ns);
    if (!camera) return std::unexpected(camera.error());
    return rig_.cameras.replace(entry, std::move(*camera));
}

Result<void> WorldDesk::apply(const world::FaultAction& action, CameraEntry& entry, TimeNs begin_ns) {
    fault::FaultSpec spec = action.fault;
    spec.begin_ns = begin_ns;
    if (action.duration_ns) spec.end_ns = begin_ns + *action.duration_ns;
    auto set = rig_.cameras.set_fault(entry, spec, rig_.seed, begin_ns);
    if (!set) return std::unexpected(set.error());
    return {};
}

Result<void> WorldDesk::apply(const world::ClearFaultAction& action, CameraEntry& entry, TimeNs begin_ns) {
    entry.camera.faults().clear(
        begin_ns, [&](const fault::Fault& one) { return action.kind.empty() || name_of(one.kind) == action.kind; });
    return {};
}

void WorldDesk::move_cameras(TimeNs world_ns) {
    std::size_t done = 0;
    for (; done < rig_.camera_moves.size() && rig_.camera_moves[done].world_ns <= world_ns; ++done) {
        const world::CameraMove& move = rig_.camera_moves[done];
        const auto act = [&](const auto& action) {
            const auto entry = rig_.cameras.find(action.camera);
            if (!entry) return spdlog::warn("an event is for camera {}, which is not there", action.camera);
            if (auto acted = apply(action, **entry, move.world_ns); !acted)
                spdlog::warn("an event is for camera {}: {}", action.camera, acted.error().message);
        };
        std::visit(act, move.action);
    }
    rig_.camera_moves.erase(rig_.camera_moves.begin(), rig_.camera_moves.begin() + static_cast<std::ptrdiff_t>(done));
}

}  // namespace camrig::engine
