#include "core/engine/fault_desk.h"

#include "core/base/clock.h"

namespace camrig::engine {

TimeNs FaultDesk::note_command(CameraEntry& entry) {
    entry.applied_ns =
        rig_.clock.running() ? rig_.schedule.next_due_ns(entry.id) : entry.latest.delivered().state.world_ns;
    return entry.applied_ns;
}

Result<FaultReply> FaultDesk::run(SetFault& command) {
    auto found = rig_.cameras.find(command.camera);
    if (!found) return std::unexpected(found.error());
    CameraEntry& entry = **found;
    world_.world_of_now();  // what events did to the camera until now comes before
    const TimeNs now_ns = rig_.world_now_ns(monotonic_now_ns());
    auto fault = rig_.cameras.set_fault(entry, command.fault, rig_.seed, now_ns);
    if (!fault) return std::unexpected(fault.error());
    return FaultReply{command.camera, *fault, note_command(entry)};
}

Result<ClearFaults::Reply> FaultDesk::run(ClearFaults& command) {
    if (!command.camera.empty())
        if (auto found = rig_.cameras.find(command.camera); !found) return std::unexpected(found.error());
    world_.world_of_now();
    const TimeNs now_ns = rig_.world_now_ns(monotonic_now_ns());
    ClearFaults::Reply reply{0, now_ns};
    for (auto& [id, entry] : rig_.cameras.all()) {
        if (!command.camera.empty() && *entry.name != command.camera) continue;
        const std::size_t cleared = entry.camera.faults().clear(now_ns, [&](const fault::Fault& one) {
            return (!command.id || one.id == *command.id) &&
                   (command.kind.empty() || name_of(one.kind) == command.kind) &&
                   (!command.by_wiper || is_wiped(one.kind));
        });
        if (cleared > 0) reply.applied_ns = std::max(reply.applied_ns, note_command(entry));
        reply.cleared += cleared;
    }
    if (command.id && reply.cleared == 0)
        return error(ErrorKind::not_found,
                     "id: there is no fault " + std::to_string(*command.id) + "; fault.list lists them");
    return reply;
}

Result<ListFaults::Reply> FaultDesk::run(ListFaults& command) {
    if (!command.camera.empty())
        if (auto found = rig_.cameras.find(command.camera); !found) return std::unexpected(found.error());
    world_.world_of_now();
    ListFaults::Reply reply{{}, rig_.world_now_ns(monotonic_now_ns())};
    for (const auto& [id, entry] : rig_.cameras.all()) {
        if (!command.camera.empty() && *entry.name != command.camera) continue;
        for (fault::FaultRef& one : entry.camera.faults().present(reply.world_ns))
            reply.faults.push_back({*entry.name, std::move(one), entry.applied_ns});
    }
    return reply;
}

Result<GetReaderLog::Reply> FaultDesk::run(GetReaderLog& command) {
    auto found = rig_.bus.reader_log().since(command.since, command.camera);
    if (!command.camera.empty() && found.events.empty())
        if (auto known = rig_.cameras.find(command.camera); !known) return std::unexpected(known.error());
    return found;
}

}  // namespace camrig::engine
