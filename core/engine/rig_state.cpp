#include "core/engine/rig_state.h"

#include <algorithm>
#include <array>

#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "core/fault/picture.h"
#include "core/fault/sending.h"
#include "core/world/backdrop/backdrop.h"

namespace camrig::engine {
namespace {

/// A command finds the world of now unless that is further away: then it finds it there on its way.
constexpr TimeNs most_ahead_ns = 2 * idle_tick_ns;

}  // namespace

TimeNs RigState::world_now_ns(TimeNs monotonic_ns) const {
    if (command_ns) return *command_ns;
    if (step_instant_ns) return *step_instant_ns;
    const TimeNs last_ns = world->last_step_ns();
    TimeNs now_ns = std::min(clock.world_at(monotonic_ns), last_ns + most_ahead_ns);
    if (clock.running()) now_ns = std::min(now_ns, agenda.gate_ns());
    // A step that takes several turns has moved the world; the clock follows when it is done.
    if (last_ns - now_ns > scene->step_ns) now_ns = last_ns;
    // An instant that is due and has not begun is still to come.
    return std::min(now_ns, schedule.next_due_ns() - 1);
}

std::shared_ptr<const world::WorldPast> RigState::world_past(TimeNs now_ns) const {
    TimeNs longest_ns = 0;
    for (const auto& [id, entry] : cameras.all()) {
        const world::CameraSpec& spec = entry.spec();
        if (!spec.sensor) continue;
        const double exposure_s = spec.sensor->exposure_s.value_or(spec.sensor->longest_exposure_s(spec.rate));
        const auto taken_ns = static_cast<TimeNs>((exposure_s + spec.sensor->readout_s) * 1e9) + 1;
        longest_ns = std::max(longest_ns, std::min(taken_ns, world::CameraPast::span_ns));
    }
    return longest_ns == 0 ? nullptr : world->past(now_ns - longest_ns);
}

void RigState::show(CameraEntry& entry, std::int64_t sequence, const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                    const std::shared_ptr<const world::WorldPast>& past) {
    cameras.show(entry, sequence, snapshot, monotonic_ns);
    entry.latest.past = entry.spec().sensor && past != nullptr
                            ? std::make_shared<const world::CameraPast>(past, entry.camera)
                            : nullptr;
}

std::shared_ptr<const render::EarlierPicture> RigState::torn_with(const CameraEntry& entry,
                                                                  const LatestDue& latest) const {
    const LatestDue* const before = latest.torn_with.get();
    if (before == nullptr) return nullptr;
    return std::make_shared<const render::EarlierPicture>(
        render::EarlierPicture{view_of(entry, *before), before->snapshot, before->monotonic_ns});
}

render::View RigState::view_of(const CameraEntry& entry, const LatestDue& latest) const {
    render::View view;
    view.camera = entry.id;
    view.name = entry.name;
    view.spec = latest.spec;
    view.spec_revision = latest.spec_revision;
    view.pose = latest.state.pose;
    view.believed_pose = latest.state.believed_pose;
    view.head = latest.state.head;
    view.clock = latest.state.clock;
    view.sensor = entry.sensor;
    view.past = latest.past;
    view.faults = latest.faults;
    if (latest.spec->backdrop_here != nullptr && latest.spec->backdrop_here->film != nullptr)
        view.film = latest.spec->backdrop_here->film->at(latest.snapshot->world_ns, options.mode == RunMode::lockstep);
    if (latest.faults && fault::changes_picture(*latest.faults))
        view.failing = std::make_shared<const render::FailingPicture>(
            render::FailingPicture{.faults = latest.faults, .torn_with = torn_with(entry, latest)});
    view.quality = latest.spec->quality.value_or(options.quality);
    view.sequence = latest.sequence;
    view.camera_number = entry.number;
    return view;
}

Result<void> RigState::look_ahead(const CameraEntry& entry, const LatestDue& latest, render::View& view) const {
    const camera::ExposureTimes times = world::exposure_times_of(*latest.spec);
    const TimeNs now_ns = latest.snapshot->world_ns,
                 then_ns = times.time_of_frame(times.frames_until(now_ns) + schedule.stride(entry.id) - 1);
    if (then_ns < world->last_step_ns() - world::CameraPast::span_ns)
        return error(ErrorKind::unavailable,
                     "camera " + *entry.name + ": the world has gone on for too long since that frame for its flow (" +
                         std::to_string(world::CameraPast::span_ns / ns_per_ms) +
                         " ms of it are kept); ask for a newer one");
    view.frame_ns = then_ns - now_ns;
    view.future = std::make_shared<world::CameraFuture>(world->copy(), *entry.name, entry.camera, camera_moves);
    return {};
}

DueViews RigState::picture_of(const CameraEntry& entry) const {
    const LatestDue& latest = entry.latest;
    const LatestDue& shown = latest.seen();
    DueViews due{shown.snapshot, shown.monotonic_ns, {view_of(entry, shown)}};
    if (&shown == &latest || latest.is_dropped()) return due;
    render::View& view = due.views.front();
    due.monotonic_ns = latest.monotonic_ns;
    view.clock = latest.state.clock;
    view.faults = latest.faults;
    view.failing = std::make_shared<const render::FailingPicture>(render::FailingPicture{
        view.failing ? view.failing->faults : nullptr, fault::FrameKey{latest.sequence, latest.state.world_ns},
        shown.colors, latest.past, view.failing ? view.failing->torn_with : nullptr});
    return due;
}

frame::PixelFormats RigState::made_of(const render::View& view, frame::PixelFormats wanted) const {
    frame::PixelFormats made;
    // What faults change later is changed in pixels, and so is what streams send smaller.
    const auto is_smaller = [&](const char* output) {
        return fault::other_size(*view.faults, output, view.spec->size).has_value();
    };
    const bool is_changed =
        (view.failing && view.failing->faults) ||
        (view.faults && std::ranges::any_of(std::array{"mjpeg", "rtsp", "device", "v4l2"}, is_smaller));
    for (const frame::PixelFormat format : frame::color_formats) {
        const bool is_made = !is_changed && drawing->makes(format, view);
        if (wanted.contains(format)) made.add(is_made ? format : frame::PixelFormat::rgba8);
    }
    return made;
}

void RigState::ask_for(render::View& view, frame::PixelFormats wanted) const {
    view.color_formats = made_of(view, wanted);
    view.kinds[index_of(frame::FrameKind::color)] = !view.color_formats.empty();
    view.kinds[index_of(frame::FrameKind::sensor)] = wanted.contains_numbers();
}

void RigState::publish(const frame::FrameSet& set, const std::shared_ptr<stream::DeliveryLatch>& latch) {
    const TimeNs start_ns = monotonic_now_ns();
    bus.publish(set, latch);
    publish_time.record(monotonic_now_ns() - start_ns);
}

void RigState::note_failure(const std::string& camera, const Error& why) {
    const TimeNs now_ns = monotonic_now_ns();
    if (now_ns - last_failure_log_ns < ns_per_s) return;
    last_failure_log_ns = now_ns;
    spdlog::error("camera {}: could not be drawn: {}", camera, why.message);
}

}  // namespace camrig::engine
