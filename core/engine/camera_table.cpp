#include "core/engine/camera_table.h"

#include <algorithm>
#include <array>

#include <spdlog/spdlog.h>

#include "core/base/names.h"
#include "core/base/output_family.h"
#include "core/fault/delivery.h"
#include "core/fault/picture.h"
#include "core/fault/sending.h"
#include "core/render/view_frames.h"

namespace camrig::engine {
namespace {

/// In user space: a device of v4l2loopback cannot be unplugged while programs have it open.
bool is_device(const OutputSpec& output) {
    return output.kind == "device";
}

}  // namespace

std::optional<stream::SensorNumbers> numbers_of(const world::CameraSpec& spec) {
    if (!spec.sensor) return std::nullopt;
    return stream::SensorNumbers{render::raw_format(spec.sensor->filter), spec.sensor->bits};
}

stream::CameraStream stream_of(const CameraEntry& entry) {
    stream::CameraStream camera{entry.id,          *entry.name,          entry.spec().size,
                                entry.spec().rate, entry.spec().outputs, numbers_of(entry.spec())};
    if (entry.unplugged) std::erase_if(camera.outputs, is_device);
    camera.standing = entry.failing;
    return camera;
}

Result<CameraEntry*> CameraTable::find(const std::string& name) {
    const auto found = std::ranges::find_if(by_id_, [&](const auto& entry) { return *entry.second.name == name; });
    if (found != by_id_.end()) return &found->second;
    std::string names;
    for (const auto& [id, entry] : by_id_) {
        if (names.size() > 200) {
            names += ", ...";
            break;
        }
        names += (names.empty() ? "" : ", ") + *entry.name;
    }
    return error(ErrorKind::not_found, "no camera '" + name.substr(0, 60) + "'; " +
                                           (names.empty() ? "there are none" : "there are: " + names));
}

CameraEntry* CameraTable::find_id(CameraId id) {
    const auto found = by_id_.find(id);
    return found == by_id_.end() ? nullptr : &found->second;
}

CameraEntry& CameraTable::at(CameraId id) {
    const auto found = by_id_.find(id);
    CHECK(found != by_id_.end());
    return found->second;
}

Result<void> CameraTable::check_pixels(std::int64_t added) const {
    std::int64_t total = added;
    for (const auto& [id, entry] : by_id_) total += entry.spec().size.pixels();
    if (total <= max_total_pixels) return {};
    return error(ErrorKind::resource_exhausted, "all cameras together would have " + std::to_string(total >> 20) +
                                                    " Mpixel; at most " + std::to_string(max_total_pixels >> 20) +
                                                    " are possible: delete cameras or make them smaller");
}

Result<CameraEntry*> CameraTable::add(world::CameraSpec spec) {
    if (auto good = check_name("name", spec.name); !good) return std::unexpected(good.error());
    if (find(spec.name)) {
        return error(ErrorKind::already_exists,
                     "camera '" + spec.name + "' exists; choose another name, or delete or set the one there");
    }
    if (by_id_.size() >= max_cameras)
        return error(ErrorKind::resource_exhausted, std::to_string(max_cameras) + " cameras exist; delete some");
    if (auto fits = check_pixels(spec.size.pixels()); !fits) return std::unexpected(fits.error());

    std::array<bool, 256> taken{};
    for (const auto& [id, entry] : by_id_) taken[entry.number] = true;

    const CameraId id{++last_id_};
    CameraEntry& entry = by_id_[id];
    entry.id = id;
    entry.number = static_cast<std::uint8_t>(std::ranges::find(taken, false) - taken.begin());
    entry.name = std::make_shared<const std::string>(spec.name);
    entry.camera = world::Camera(std::move(spec));
    entry.spec_revision = ++last_revision_;
    return &entry;
}

Result<void> CameraTable::replace(CameraEntry& entry, world::Camera camera) {
    if (auto fits = check_pixels(camera.spec()->size.pixels() - entry.spec().size.pixels()); !fits) return fits;
    entry.camera = std::move(camera);
    entry.spec_revision = ++last_revision_;
    return {};
}

namespace {

/// The frame whose picture is to be seen again by these faults of the next one, which does not come or repeats it;
/// null: the next has its own, or there was none yet.
std::shared_ptr<LatestDue> shown_again(const CameraEntry& entry, const fault::FrameFaults& faults) {
    const LatestDue& latest = entry.latest;
    const LatestDue& seen = latest.seen();
    const bool is_there =
        latest.spec && !(latest.is_dropped() && !latest.shown) && seen.spec->size == entry.spec().size;
    if (!is_there || !(faults.is_dropped || is_repeat(faults, seen.state.world_ns))) return nullptr;
    return latest.shown ? latest.shown : std::make_shared<LatestDue>(latest);
}

/// The picture that the lower part of this frame's is of; null: of its own.
std::shared_ptr<const LatestDue> torn_with(const CameraEntry& entry, const fault::FrameFaults& faults) {
    const LatestDue& before = entry.latest.seen();
    if (!before.spec || before.spec->size != entry.spec().size || torn_rows(faults, before.spec->size.height) == 0)
        return nullptr;
    auto kept = std::make_shared<LatestDue>(before);
    kept->torn_with = nullptr;
    kept->shown = nullptr;
    return kept;
}

}  // namespace

void CameraTable::show(CameraEntry& entry, std::int64_t sequence, world::SnapshotRef snapshot, TimeNs monotonic_ns) {
    LatestDue& latest = entry.latest;
    auto faults = entry.camera.faults().at({sequence, snapshot->world_ns});
    // Both of what was shown until now.
    auto torn = faults ? torn_with(entry, *faults) : nullptr;
    auto again = faults ? shown_again(entry, *faults) : nullptr;
    latest.torn_with = std::move(torn);
    latest.shown = std::move(again);
    if (latest.shown) faults->shown_sequence = latest.shown->sequence;
    latest.faults = faults ? std::make_shared<const fault::FrameFaults>(std::move(*faults)) : nullptr;
    const camera::CameraState before = std::exchange(latest.state, entry.camera.at(*snapshot));
    // A camera that is zoomed in and stands is the same from picture to picture.
    const bool is_as_before =
        latest.source_revision == entry.spec_revision && latest.state.intrinsics == before.intrinsics;
    if (!is_as_before) {
        latest.spec = entry.camera.spec();
        latest.spec_revision = latest.source_revision = entry.spec_revision;
        if (latest.state.intrinsics != latest.spec->intrinsics) {
            auto zooming = std::make_shared<world::CameraSpec>(*latest.spec);
            zooming->intrinsics = latest.state.intrinsics;
            latest.spec = std::move(zooming);
            latest.spec_revision = ++last_revision_;
        }
    }
    latest.sequence = sequence;
    latest.monotonic_ns = monotonic_ns;
    latest.snapshot = std::move(snapshot);
    latest.colors.clear();
}

LatestDue CameraTable::at_instant(const CameraEntry& entry, const HeldInstant& instant) {
    LatestDue due;
    due.spec = entry.camera.spec();
    due.spec_revision = due.source_revision = entry.spec_revision;
    due.sequence = instant.sequence;
    due.state = entry.camera.at(*instant.snapshot);
    due.monotonic_ns = instant.monotonic_ns;
    due.snapshot = instant.snapshot;
    const LatestDue& latest = entry.latest;
    if (latest.source_revision == entry.spec_revision && latest.state.intrinsics == due.state.intrinsics) {
        due.spec = latest.spec;
        due.spec_revision = latest.spec_revision;
    } else if (due.state.intrinsics != due.spec->intrinsics) {
        auto zooming = std::make_shared<world::CameraSpec>(*due.spec);
        zooming->intrinsics = due.state.intrinsics;
        due.spec = std::move(zooming);
        due.spec_revision = ++last_revision_;
    }
    if (auto faults = entry.camera.faults().at({latest.sequence, due.state.world_ns})) {
        faults->is_dropped = false;
        due.faults = std::make_shared<const fault::FrameFaults>(std::move(*faults));
    }
    return due;
}

void CameraTable::keep_colors(CameraEntry& entry, const render::View& view, std::span<const frame::FrameRef> frames) {
    const auto is_of = [&](const LatestDue& due) {
        return due.sequence == view.sequence && due.spec_revision == view.spec_revision;
    };
    const auto add = [&](LatestDue& due) {
        for (const frame::FrameRef& frame : frames) {
            if (frame->info().kind != frame::FrameKind::color) continue;
            std::erase_if(due.colors, [&](const auto& old) { return old->info().format == frame->info().format; });
            due.colors.push_back(frame);
        }
    };
    LatestDue& latest = entry.latest;
    const bool is_shown_as_latest =
        view.failing && view.failing->shown_as && view.failing->shown_as->sequence == latest.sequence;
    if (latest.shown ? is_shown_as_latest : is_of(latest)) add(latest);
    if (latest.shown && is_of(*latest.shown)) add(*latest.shown);
}

namespace {

/// What happens to a camera whose devices come back.
world::CameraPatch replug_patch(const world::CameraSpec& spec, const fault::Unplug& was) {
    world::CameraPatch patch;
    if (was.as_number >= 0) {
        patch.outputs = spec.outputs;
        const auto device = std::ranges::find_if(*patch.outputs, is_device);
        if (device != patch.outputs->end()) device->options["number"] = was.as_number;
    }
    if (was.replug_resets_controls) patch.change([](world::CameraSpec& plugged) { plugged.controls = {}; });
    return patch;
}

}  // namespace

Result<fault::FaultRef> CameraTable::set_fault(CameraEntry& entry, const fault::FaultSpec& spec, std::uint64_t rig_seed,
                                               TimeNs now_ns) {
    if (entry.spec().backdrop && entry.spec().backdrop->stands_still() &&
        fault::layer_of(spec.kind) == fault::Layer::body)
        return error(
            ErrorKind::unsupported,
            "kind: camera " + *entry.name +
                " has a backdrop, which shows the place as it looked from where the camera stands; it cannot be "
                "moved by a fault");
    if (std::holds_alternative<fault::DeviceError>(spec.kind) && std::ranges::none_of(entry.spec().outputs, is_device))
        return error(ErrorKind::unsupported, "kind: camera " + *entry.name +
                                                 " has no user-space device (output device); the kernel answers calls "
                                                 "of v4l2loopback's");
    if (const auto* const out = std::get_if<fault::Unplug>(&spec.kind)) {
        if (std::ranges::none_of(entry.spec().outputs, is_device))
            return error(ErrorKind::unsupported,
                         "kind: camera " + *entry.name +
                             " has no user-space device (output device) that could be unplugged, and a v4l2loopback "
                             "device cannot be while programs have it open; let that stall (kind stall)");
        const auto replugged = entry.camera.changed(replug_patch(entry.spec(), *out), now_ns, 0);
        if (!replugged) return camrig::at("params.as_number", replugged.error());
        if (auto free = check_free(*replugged->spec()); !free) return camrig::at("params.as_number", free.error());
    }
    auto fault = entry.camera.faults().set(spec, last_fault_ + 1, rig_seed, now_ns);
    if (fault) ++last_fault_;
    return fault;
}

Result<void> CameraTable::check_free(const world::CameraSpec& spec) const {
    for (const OutputSpec& output : spec.outputs) {
        const OutputFamily& family = family_of(output);
        if (!family.is_key_of_rig) continue;
        for (const auto& [id, entry] : by_id_) {
            if (*entry.name == spec.name) continue;
            for (const OutputSpec& taken : entry.spec().outputs)
                if (is_same_output(taken, output))
                    return error(ErrorKind::already_exists, "outputs: " + output.kind + " " + family.key + " " +
                                                                key_of(output).dump() + " belongs to camera " +
                                                                *entry.name + "; choose another");
        }
    }
    return {};
}

bool CameraTable::follow_outputs(CameraEntry& entry, TimeNs world_ns) {
    const fault::Standing now = entry.latest.faults ? standing_of(*entry.latest.faults) : fault::Standing{};
    const bool is_another = std::exchange(entry.failing, now) != now;
    return follow_plug(entry, world_ns) || is_another;
}

bool CameraTable::follow_plug(CameraEntry& entry, TimeNs world_ns) {
    const fault::Unplug* const out = entry.latest.faults ? unplug_of(*entry.latest.faults) : nullptr;
    if (!out && !entry.unplugged) return false;
    if (out) return !std::exchange(entry.unplugged, *out);
    const fault::Unplug was = *std::exchange(entry.unplugged, std::nullopt);
    auto changed = entry.camera.changed(replug_patch(entry.spec(), was), world_ns, 0);
    Result<void> good = changed ? check_free(*changed->spec()) : std::unexpected(changed.error());
    if (good) good = replace(entry, std::move(*changed));
    // Another camera may have got the number meanwhile.
    if (!good) spdlog::warn("camera {} is plugged in again as it was: {}", *entry.name, good.error().message);
    return true;
}

Result<CameraEntry> CameraTable::remove(const std::string& name) {
    auto found = find(name);
    if (!found) return std::unexpected(found.error());
    CameraEntry entry = std::move(**found);
    by_id_.erase(entry.id);
    return entry;
}

}  // namespace camrig::engine
