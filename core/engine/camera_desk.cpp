#include "core/engine/camera_desk.h"

#include <algorithm>
#include <tuple>

#include "core/base/clock.h"
#include "core/base/output_family.h"

namespace camrig::engine {
Result<CameraReply> CameraDesk::run(CreateCamera& command) {
    world::CameraSpec base;
    base.name = command.name;
    world::CameraPatch patch = command.patch;
    if (command.place) {
        const auto found = rig_.scene->places.find(*command.place);
        if (found == rig_.scene->places.end()) {
            std::string names;
            for (const auto& [name, place] : rig_.scene->places) names += (names.empty() ? "" : ", ") + name;
            return error(ErrorKind::not_found, "place: the scene has no place '" + command.place->substr(0, 60) +
                                                   "'; " + (names.empty() ? "it has none" : "it has: " + names));
        }
        if (!patch.pose) patch.pose = found->second.pose;
        if (!patch.optics) patch.optics = world::VerticalFov{found->second.vfov_rad};
    }
    if (auto good = check_mount(patch); !good) return std::unexpected(good.error());
    auto spec = patch_camera_spec(base, patch);
    if (!spec) return std::unexpected(spec.error());
    if (auto good = check_new_outputs(*spec, {}); !good) return std::unexpected(good.error());
    auto entry = add_camera(std::move(*spec));
    if (!entry) return std::unexpected(entry.error());
    return report_of(**entry);
}

Result<CameraEntry*> CameraDesk::add_camera(world::CameraSpec spec) {
    if (auto good = rig_.cameras.check_free(spec); !good) return std::unexpected(good.error());
    auto entry = rig_.cameras.add(std::move(spec));
    if (entry) start_camera(**entry);
    return entry;
}

void CameraDesk::start_camera(CameraEntry& entry) {
    // Its first picture shows the moment it was made, with the number just before that of its next grid point: at world
    // time 0 that is frame 0 itself, or, of a camera that is due later, a frame 0 before its first grid point.
    const TimeNs now_ns = rig_.world_now_ns(monotonic_now_ns());
    const camera::ExposureTimes times = entry.exposure_times();
    const std::int64_t next = std::max<std::int64_t>(1, times.frames_until(now_ns));
    rig_.schedule.set(entry.id, times, now_ns, next);
    renew_latest(entry, next - 1);
    rig_.bus.add_camera(stream_of(entry));
}

Result<void> CameraDesk::check_mount(const world::CameraPatch& patch) {
    if (!patch.mount || !*patch.mount) return {};
    return world_.world_of_now().check_mount(**patch.mount, "mount");
}

Result<void> CameraDesk::check_new_outputs(const world::CameraSpec& spec, const std::vector<OutputSpec>& present) {
    for (const OutputSpec& output : spec.outputs) {
        const auto& can_open = family_of(output).can_open;
        if (!can_open) continue;
        if (std::ranges::any_of(present, [&](const OutputSpec& one) { return is_same_output(one, output); })) continue;
        if (auto good = can_open(output, spec.name); !good) return at("outputs", good.error());
    }
    return {};
}

void CameraDesk::renew_latest(CameraEntry& entry, std::int64_t sequence) {
    TimeNs monotonic_ns = monotonic_now_ns();
    const TimeNs now_ns = rig_.world_now_ns(monotonic_ns);
    if (rig_.clock.running()) monotonic_ns = rig_.clock.monotonic_at(now_ns);
    rig_.world->advance_to(now_ns);
    rig_.show(entry, sequence, rig_.world->snapshot(now_ns), monotonic_ns, rig_.world_past(now_ns));
}

/// Nothing falls due while the world stands still, yet the change must show. In real time it is a frame more. In
/// lockstep readers are sent what is due and nothing else: who asks gets the frame that is there, drawn anew.
void CameraDesk::renew_standing(CameraEntry& entry, TimeNs now_ns) {
    if (rig_.options.mode != RunMode::realtime) return renew_latest(entry, entry.latest.sequence);
    const std::int64_t next = rig_.schedule.next_sequence(entry.id);
    rig_.schedule.set(entry.id, entry.exposure_times(), now_ns, next + 1);
    renew_latest(entry, next);
}

void CameraDesk::show_waiting_change(CameraEntry& entry) {
    if (rig_.clock.running() || rig_.options.mode != RunMode::realtime) return;
    if (entry.applied_ns <= entry.latest.state.world_ns) return;
    renew_standing(entry, rig_.world_now_ns(monotonic_now_ns()));
    entry.applied_ns = entry.latest.state.world_ns;
    if (!rig_.bus.wanted(entry.id, entry.latest.state.world_ns).empty()) show_latest(entry);
}

void CameraDesk::show_latest(CameraEntry& entry) {
    const LatestDue& latest = entry.latest;
    DueViews due = rig_.picture_of(entry);
    if (const frame::PixelFormats wanted = rig_.bus.wanted(entry.id, latest.state.world_ns); !wanted.empty())
        rig_.ask_for(due.views.front(), wanted);
    rig_.drawing->add(due);
}

Result<CameraReply> CameraDesk::run(SetCamera& command) {
    auto found = rig_.cameras.find(command.name);
    if (!found) return std::unexpected(found.error());
    CameraEntry& entry = **found;
    if (auto good = check_mount(command.patch); !good) return std::unexpected(good.error());
    const TimeNs now_ns = rig_.world_now_ns(monotonic_now_ns());
    world_.world_of_now();  // what events did to the camera until now comes before
    const std::shared_ptr<const world::CameraSpec> old = entry.camera.spec();
    auto changed = entry.camera.changed(command.patch, now_ns, command.duration_ns);
    if (!changed) return std::unexpected(changed.error());
    if (auto good = rig_.cameras.check_free(*changed->spec()); !good) return std::unexpected(good.error());
    if (auto good = check_new_outputs(*changed->spec(), old->outputs); !good) return std::unexpected(good.error());
    if (auto good = rig_.cameras.replace(entry, std::move(*changed)); !good) return std::unexpected(good.error());

    if (entry.exposure_times() != exposure_times_of(*old))
        rig_.schedule.set(entry.id, entry.exposure_times(), now_ns, rig_.schedule.next_sequence(entry.id));
    TimeNs applied_ns = rig_.schedule.next_due_ns(entry.id);
    const bool stands_still = !rig_.clock.running() && rig_.options.mode == RunMode::realtime;
    if (!rig_.clock.running()) {
        renew_standing(entry, now_ns);
        applied_ns = entry.latest.state.world_ns;
    }
    if (entry.spec().size != old->size || entry.spec().rate != old->rate || entry.spec().outputs != old->outputs ||
        numbers_of(entry.spec()) != numbers_of(*old))
        rig_.bus.change_camera(stream_of(entry));
    rig_.bus.adjust_camera(stream_of(entry));
    if (stands_still && !rig_.bus.wanted(entry.id, entry.latest.state.world_ns).empty()) show_latest(entry);
    entry.applied_ns = applied_ns;
    CameraReply report = report_of(entry);
    report.applied_ns = applied_ns;
    return report;
}

Result<Applied> CameraDesk::run(DeleteCamera& command) {
    auto removed = rig_.cameras.remove(command.name);
    if (!removed) return std::unexpected(removed.error());
    const Applied applied{rig_.world_now_ns(monotonic_now_ns())};
    rig_.schedule.remove(removed->id);
    rig_.bus.remove_camera(removed->id);
    rig_.drawing->forget(removed->id);
    return applied;
}

Result<CameraReply> CameraDesk::run(GetCamera& command) {
    auto found = rig_.cameras.find(command.name);
    if (!found) return std::unexpected(found.error());
    return report_of(**found);
}

Result<std::vector<CameraReply>> CameraDesk::run(ListCameras&) {
    std::vector<CameraReply> reports;
    for (const auto& [id, entry] : rig_.cameras.all()) reports.push_back(report_of(entry));
    return reports;
}

Result<PtzReply> CameraDesk::tell_head(
    const std::string& camera,
    const std::function<Result<void>(camera::PtzHead&, const world::Camera&, TimeNs)>& tell) {
    auto found = rig_.cameras.find(camera);
    if (!found) return std::unexpected(found.error());
    CameraEntry& entry = **found;
    const TimeNs now_ns = rig_.world_now_ns(monotonic_now_ns());
    world_.world_of_now();  // what events did to the camera until now comes before
    auto told = entry.camera.with_head([&](camera::PtzHead& head) { return tell(head, entry.camera, now_ns); });
    if (!told) return std::unexpected(told.error());
    entry.camera = std::move(*told);  // its spec is as it was, and so is what is kept of its pictures
    rig_.bus.adjust_camera(stream_of(entry));
    entry.applied_ns = rig_.clock.running() ? rig_.schedule.next_due_ns(entry.id) : entry.latest.state.world_ns;
    return head_of(entry, now_ns);
}

Result<PtzReply> CameraDesk::head_of(const CameraEntry& entry, TimeNs now_ns) const {
    const auto head = entry.camera.head();
    if (!head) return std::unexpected(head.error());
    return PtzReply{(*head)->status(now_ns), now_ns,           (*head)->arrives_ns(), (*head)->presets(),
                    entry.applied_ns,        (*head)->tours(), (*head)->tour()};
}

Result<PtzReply> CameraDesk::run(MovePtz& command) {
    return tell_head(command.camera,
                     [&](camera::PtzHead& head, const world::Camera& camera, TimeNs now_ns) -> Result<void> {
                         const auto move = camera.in_angles(command.move, now_ns);
                         if (!move) return std::unexpected(move.error());
                         return head.move(*move, now_ns);
                     });
}

Result<PtzReply> CameraDesk::run(PtzPresets& command) {
    return tell_head(command.camera, [&](camera::PtzHead& head, const world::Camera&, TimeNs now_ns) -> Result<void> {
        switch (command.action) {
            using enum PtzPresets::Action;
            case add:
                if (head.presets().contains(command.preset))
                    return error(ErrorKind::already_exists, "there is a preset '" + command.preset + "'");
                [[fallthrough]];
            case set:
                return head.set_preset(command.preset, now_ns);
            case go_to:
                return head.go_to_preset(command.preset, command.speed, now_ns);
            case remove:
                return head.remove_preset(command.preset);
            case set_home:
                head.set_home(now_ns);
                break;
            case go_home:
                return head.go_home(command.speed, now_ns);
        }
        return {};
    });
}

Result<PtzReply> CameraDesk::run(PtzTours& command) {
    return tell_head(command.camera, [&](camera::PtzHead& head, const world::Camera&, TimeNs now_ns) -> Result<void> {
        switch (command.action) {
            using enum PtzTours::Action;
            case set:
                return head.set_tour(command.tour, command.stops);
            case start:
                return head.start_tour(command.tour, now_ns);
            case remove:
                return head.remove_tour(command.tour);
        }
        return {};
    });
}

Result<PtzReply> CameraDesk::run(StopPtz& command) {
    return tell_head(command.camera, [&](camera::PtzHead& head, const world::Camera&, TimeNs now_ns) -> Result<void> {
        return head.stop(command.pan_tilt, command.zoom, now_ns);
    });
}

Result<PtzReply> CameraDesk::run(GetPtz& command) {
    auto found = rig_.cameras.find(command.camera);
    if (!found) return std::unexpected(found.error());
    return head_of(**found, rig_.world_now_ns(monotonic_now_ns()));
}

CameraReply CameraDesk::report_of(const CameraEntry& entry) const {
    // Alone, a camera needs only the time; where its actor is now, the world would have to be asked.
    const world::Snapshot alone{.world_ns = rig_.world_now_ns(monotonic_now_ns()), .statics = {}, .movers = {}};
    return {.id = entry.id,
            .camera = entry.camera,
            .now = entry.camera.at(entry.spec().mount ? *entry.latest.snapshot : alone),
            .sequence = entry.latest.sequence,
            .readers = rig_.bus.reader_count(entry.id),
            .applied_ns = entry.latest.state.world_ns};
}

Result<void> CameraDesk::add_cameras_of(const world::Scene& scene) {
    added_.clear();
    for (const world::CameraSpec& spec : scene.cameras) {
        if (rig_.cameras.find(spec.name)) continue;
        auto good = rig_.cameras.check_free(spec);
        if (good) good = check_new_outputs(spec, {});
        const auto entry = good ? rig_.cameras.add(spec) : Result<CameraEntry*>(std::unexpected(good.error()));
        if (!entry) {
            for (const CameraId id : added_) std::ignore = rig_.cameras.remove(std::string(*rig_.cameras.at(id).name));
            added_.clear();
            return at(scene.file.string() + ": camera " + spec.name, entry.error());
        }
        added_.push_back((*entry)->id);
    }
    return {};
}

void CameraDesk::show_all() {
    for (auto& [id, entry] : rig_.cameras.all()) show_latest(entry);
}

void CameraDesk::begin_world() {
    // World time starts again at 0; cameras stay, and their sequence numbers go on. Readers are shown the new world
    // before its clock runs: that pays for its textures, so it costs no frames.
    std::vector<CameraEntry*> stayed;
    for (auto& [id, entry] : rig_.cameras.all()) {
        if (std::ranges::find(added_, id) != added_.end()) continue;
        rig_.schedule.set(id, entry.exposure_times(), 0, rig_.schedule.next_sequence(id) + 1);
        entry.applied_ns = 0;
        entry.not_drawn.clear();
        stayed.push_back(&entry);
    }
    for (CameraEntry* entry : stayed) entry->camera = entry->camera.in_another_world(*entry->latest.snapshot);
    world_.world_of_now();  // first pictures show what events did to cameras at the begin
    for (CameraEntry* entry : stayed) {
        renew_latest(*entry, rig_.schedule.next_sequence(entry->id) - 1);
        if (!rig_.bus.wanted(entry->id, 0).empty()) show_latest(*entry);
    }
    for (const CameraId id : added_) start_camera(rig_.cameras.at(id));
}

}  // namespace camrig::engine
