#include "core/engine/replica_desk.h"

#include <algorithm>
#include <utility>

#include "core/base/clock.h"
#include "core/base/digest.h"
#include "core/world/camera_json.h"

namespace camrig::engine {
namespace {

/// A clock that is less off is made good at this rate.
constexpr TimeNs most_slewed_ns = 2 * ns_per_ms;
constexpr TimeNs slew_ns_per_ms = 500;

void add_head(Digest& digest, const camera::PtzHead& head, TimeNs now_ns) {
    const auto add_position = [&](const camera::PtzPosition& at) { digest.add(at.pan_deg, at.tilt_deg, at.zoom); };
    const camera::PtzStatus status = head.status(now_ns);
    add_position(head.at(now_ns));
    add_position(status.position);
    digest.add(head.arrives_ns(), head.presets().size());
    for (const auto& [name, position] : head.presets()) {
        digest.add(name);
        add_position(position);
    }
    for (const auto& [name, stops] : head.tours()) {
        digest.add(name, stops.size());
        for (const camera::PtzTourStop& stop : stops) digest.add(stop.preset, stop.dwell, stop.speed);
    }
    digest.add(head.tour());
    add_position(head.home());
}

/// All that decides what a camera shows, and with which numbers. `due_ns` and `sequence` are of its next frame.
std::uint64_t digest_of(CameraEntry& entry, const world::Snapshot& now, TimeNs due_ns, std::int64_t sequence,
                        std::int64_t stride) {
    if (entry.spec_digest.first != entry.spec_revision || entry.spec_digest.second == 0) {
        Digest spec;
        spec.add(world::camera_to_json(entry.spec()).dump());
        entry.spec_digest = {entry.spec_revision, spec.value()};
    }
    Digest digest;
    digest.add(static_cast<std::uint32_t>(entry.id), std::uint32_t{entry.number}, *entry.name, due_ns, sequence, stride,
               entry.spec_digest.second, entry.camera.arrives_ns());
    const camera::CameraState state = entry.camera.at(now);
    const camera::Intrinsics& optics = state.intrinsics;
    digest.add(state.pose.position, state.pose.orientation, optics.fx, optics.fy, optics.cx, optics.cy);
    if (const auto head = entry.camera.head()) add_head(digest, **head, now.world_ns);
    for (const fault::FaultRef& fault : entry.camera.faults().present(now.world_ns))
        digest.add(fault->id, name_of(fault->kind), fault->begin_ns, fault->end_ns, fault->severity, fault->seed,
                   fault::params_of(fault->kind).dump());
    return digest.value();
}

}  // namespace

Result<SetLimit::Reply> ReplicaDesk::run(SetLimit& command) {
    if (state_.options.mode == RunMode::lockstep)
        return error(ErrorKind::unsupported, "in lockstep the world moves by world.step only; it needs no limit");
    const TimeNs monotonic_ns = monotonic_now_ns();
    if (command.until_ns) {
        if (state_.clock.running() && state_.clock.world_at(monotonic_ns) > state_.agenda.limit_ns())
            state_.held_until_ns = std::max(state_.held_until_ns, state_.clock.world_at(monotonic_ns));
        state_.agenda.set_limit(std::max(*command.until_ns, state_.world_now_ns(monotonic_ns)));
    }
    if (command.clock_ns && state_.clock.running()) set_clock(*command.clock_ns, monotonic_ns);
    return SetLimit::Reply{state_.world_now_ns(monotonic_ns), state_.agenda.limit_ns(), state_.agenda.size()};
}

void ReplicaDesk::set_clock(TimeNs world_ns, TimeNs monotonic_ns) {
    WorldClock& clock = state_.clock;
    const TimeNs is_ns = clock.world_at(monotonic_ns), off_ns = world_ns - is_ns;
    const TimeNs elapsed_ms = std::min(monotonic_ns - std::exchange(clock_set_ns_, monotonic_ns), ns_per_s) / ns_per_ms;
    if (std::abs(off_ns) < most_slewed_ns) {
        const TimeNs most_ns = slew_ns_per_ms * elapsed_ms;
        return clock.run(is_ns + std::clamp(off_ns, -most_ns, most_ns), monotonic_ns);
    }
    if (off_ns > 0) state_.held_until_ns = std::max(state_.held_until_ns, world_ns);
    clock.run(std::max(world_ns, state_.world_now_ns(monotonic_ns)), monotonic_ns);
}

Result<GetDigest::Reply> ReplicaDesk::run(GetDigest& command) {
    const world::World& world = world_.world_of_now();
    GetDigest::Reply reply;
    // The clock has gone on since the world was brought there.
    reply.world_ns = std::min(state_.world_now_ns(monotonic_now_ns()), world.last_step_ns());
    reply.world = world.state_hash();
    reply.state_ns = reply.world.world_ns;
    if (command.with_parts) reply.parts = world.digests();
    const world::SnapshotRef now = world.snapshot(reply.world_ns);
    Digest cameras, all;
    for (auto& [id, entry] : state_.cameras.all()) {
        const std::uint64_t one = digest_of(entry, *now, state_.schedule.next_due_ns(id),
                                            state_.schedule.next_sequence(id), state_.schedule.stride(id));
        cameras.add(one);
        if (command.with_parts) reply.parts.push_back({"camera " + *entry.name, one});
    }
    reply.cameras = cameras.value();
    reply.commands = state_.agenda.digest();
    reply.command_count = state_.agenda.done();
    all.add(reply.world_ns, reply.world.value, reply.cameras, reply.commands);
    reply.value = all.value();
    return reply;
}

}  // namespace camrig::engine
