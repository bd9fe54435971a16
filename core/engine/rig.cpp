#include "core/engine/rig.h"

#include <algorithm>
#include <array>
#include <set>

#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "core/world/mount.h"

namespace camrig {
namespace {

/// With no camera due, the world still keeps up this often, so that it never has to catch up much at once.
constexpr TimeNs idle_tick_ns = 100 * ns_per_ms;
/// Policy slow: how late a picture may be before the world waits.
constexpr TimeNs slow_tolerance_ns = 20 * ns_per_ms;
/// For so long an instant is drawn, some views at least, before that goes out and commands have their turn: encoders
/// begin while the rest is drawn, and the first camera's reader need not wait for the last camera.
constexpr TimeNs turn_ns = ns_per_ms;
constexpr std::size_t turn_views = 2;  ///< one a core: fewer are drawn in pieces
/// An instant that begins so late tells that the machine is full. Then pictures a second matter more than the age of
/// the first, and a turn has more views: at the end of each the threads that draw wait for the slowest of them.
constexpr TimeNs late_ns = 10 * ns_per_ms;
constexpr TimeNs late_turn_ns = 40 * ns_per_ms;
constexpr std::size_t late_turn_views = 4;
/// What a view is taken to cost before one was drawn.
constexpr TimeNs first_view_cost_ns = 8 * ns_per_ms;
/// For so long the world makes steps before commands have their turn; one step may take longer.
constexpr TimeNs world_turn_ns = 5 * ns_per_ms;
/// A command finds the world of now unless that is further away: then it finds it there on its way.
constexpr TimeNs most_ahead_ns = 2 * idle_tick_ns;

}  // namespace

Rig::Rig(const EngineOptions& options, std::unique_ptr<Renderer> renderer, LocalFrameBus& bus,
         std::function<void()> wake)
    : options_(options),
      bus_(bus),
      wake_(std::move(wake)),
      renderer_(std::move(renderer)),
      view_cost_ns_(first_view_cost_ns),
      request_cost_ns_(first_view_cost_ns) {}

Result<std::unique_ptr<Rig>> Rig::create(SceneRef scene, const EngineOptions& options,
                                         std::unique_ptr<Renderer> renderer, LocalFrameBus& bus,
                                         std::function<void()> wake) {
    std::unique_ptr<Rig> rig(new Rig(options, std::move(renderer), bus, std::move(wake)));
    rig->thread_.check();
    if (auto loaded = rig->load(std::move(scene)); !loaded) return std::unexpected(loaded.error());
    for (auto& [id, entry] : rig->cameras_.all()) rig->show_latest(entry);
    if (options.mode == RunMode::realtime) rig->clock_.run(0, monotonic_now_ns());
    return rig;
}

Rig::~Rig() {
    const Error why{ErrorKind::unavailable, "the rig shuts down"};
    for (auto& step : steps_) step.done(std::unexpected(why));
    for (auto& waiter : waiting_) waiter.done(std::unexpected(why));
    for (auto& wait : waits_) wait.done(std::unexpected(why));
}

TimeNs Rig::wake_time_ns() const {
    if (drawing_ || is_world_behind_) return 0;
    TimeNs wake = max_time_ns;
    if (clock_.running()) {
        wake = monotonic_now_ns() + idle_tick_ns;
        if (!schedule_.empty()) wake = std::min(wake, clock_.monotonic_at(schedule_.next_due_ns()));
    } else if (!steps_.empty()) {
        wake = steps_.front().deadline_ns;
    }
    for (const auto& waiter : waiting_) wake = std::min(wake, waiter.deadline_ns);
    for (const auto& wait : waits_) wake = std::min(wake, wait.deadline_ns);
    if (is_request_ready_) wake = std::min(wake, next_request_ns(monotonic_now_ns()));
    return wake;
}

TimeNs Rig::world_now_ns(TimeNs monotonic_ns) const {
    // A step may have drawn its next instant already, while the one before is on its way: the world is there.
    if (!steps_.empty() && steps_.front().ready) return steps_.front().ready->world_ns;
    const TimeNs last_ns = world_->last_step_ns();
    TimeNs now_ns = std::min(clock_.world_at(monotonic_ns), last_ns + most_ahead_ns);
    // A step that takes several turns has moved the world; the clock follows when it is done.
    if (last_ns - now_ns > scene_->step_ns) now_ns = last_ns;
    return std::min(now_ns, schedule_.next_due_ns());
}

void Rig::tick(TimeNs monotonic_ns) {
    thread_.check();
    const TimeNs began_ns = monotonic_now_ns();
    if (drawing_) {
        draw_turn();
        if (drawing_) return;
    } else {
        is_world_behind_ = false;
        if (clock_.running())
            run_realtime(monotonic_ns);
        else
            advance_step(monotonic_ns);
    }
    answer_waiting(monotonic_ns + (monotonic_now_ns() - began_ns));
    answer_waits(monotonic_ns);
}

void Rig::run_realtime(TimeNs monotonic_ns) {
    const TimeNs next_ns = schedule_.next_due_ns();
    const TimeNs now_ns = clock_.world_at(monotonic_ns);
    if (next_ns > now_ns) {
        chosen_late_ns_.reset();
        advance_world(now_ns);
        return;
    }
    if (!chosen_late_ns_) {
        chosen_late_ns_ = now_ns - next_ns;
        wakeup_.record(*chosen_late_ns_);
        if (options_.overload == OverloadPolicy::drop)
            account_skipped(schedule_.choose_instant(now_ns));
        else if (*chosen_late_ns_ > slow_tolerance_ns)
            clock_.run(next_ns + slow_tolerance_ns, monotonic_ns);
    }
    const TimeNs instant_ns = schedule_.next_due_ns();
    if (!advance_world(instant_ns)) return;
    drawing_ = begin_instant(instant_ns, clock_.monotonic_at(instant_ns));
    drawing_->is_late = *chosen_late_ns_ > late_ns;
    chosen_late_ns_.reset();
    draw_turn();
}

bool Rig::advance_world(TimeNs world_ns) {
    const TimeNs start_ns = monotonic_now_ns();
    TimeNs end_ns = start_ns;
    while (world_->last_step_ns() < world_ns && end_ns - start_ns < world_turn_ns) {
        world_->advance_to(std::min(world_ns, world_->last_step_ns() + scene_->step_ns));
        end_ns = monotonic_now_ns();
    }
    world_spent_ns_ += end_ns - start_ns;
    collect_world();
    move_cameras(std::min(world_ns, world_->last_step_ns()));
    is_world_behind_ = world_->last_step_ns() < world_ns;
    return !is_world_behind_;
}

void Rig::draw_turn() {
    const TimeNs time_ns = drawing_->is_late ? late_turn_ns : turn_ns;
    const std::size_t least = drawing_->is_late ? late_turn_views : turn_views;
    const std::size_t views = std::max(least, static_cast<std::size_t>(time_ns / view_cost_ns_));
    publish(draw_some(*drawing_, views), nullptr);
    if (drawing_->is_done()) drawing_.reset();
}

void Rig::finish_turns() {
    while (drawing_) draw_turn();
}

void Rig::account_skipped(TimeNs instant_ns) {
    constexpr std::int64_t max_counted_one_by_one = 4096;
    std::set<TimeNs> instants;
    std::int64_t most = 0;
    for (const auto& skipped : schedule_.skip_before(instant_ns)) {
        CameraEntry& entry = cameras_.at(skipped.camera);
        const auto frames = static_cast<std::uint64_t>(skipped.frames);
        if (!bus_.wanted(skipped.camera, skipped.first_ns).empty()) {
            entry.due += frames;
            entry.dropped += frames;
        } else {
            entry.idle += frames;
        }
        const Rate& rate = entry.spec->rate;
        const std::int64_t first = rate.first_frame_at_or_after(skipped.first_ns);
        for (std::int64_t i = 0; i < std::min(skipped.frames, max_counted_one_by_one); ++i)
            instants.insert(rate.time_of_frame(first + i));
        most = std::max(most, skipped.frames);
    }
    const auto count = std::max(static_cast<std::uint64_t>(most), static_cast<std::uint64_t>(instants.size()));
    instants_ += count;
    dropped_instants_ += count;
}

void Rig::advance_step(TimeNs monotonic_ns) {
    if (steps_.empty()) return;
    StepJob& job = steps_.front();
    // The next instant is drawn while the last one is on its way; it is published when that has arrived.
    const TimeNs next_ns = schedule_.next_due_ns();
    if (!job.ready && next_ns <= job.target_ns && advance_world(next_ns)) {
        Drawing drawing = begin_instant(next_ns, monotonic_now_ns());
        job.ready = draw_some(drawing, drawing.views.size());
    }

    if (job.latch && !job.latch->is_open()) {
        if (monotonic_ns < job.deadline_ns) return;
        std::string laggards;
        for (const auto& who : job.latch->holders()) laggards += (laggards.empty() ? "" : "; ") + who;
        clock_.hold(world_now_ns(monotonic_ns));
        job.done(error(ErrorKind::unavailable,
                       "the step waits for " + laggards.substr(0, 500) + " since " +
                           std::to_string(job.timeout_ns / ns_per_ms) + " ms and was given up at world time " +
                           std::to_string(clock_.world_at(0)) + " ns; close that reader or give a longer timeout_s"));
        if (job.ready) publish(*job.ready, nullptr);
        steps_.pop_front();
        return wake_();
    }
    if (job.ready) {
        clock_.hold(job.ready->world_ns);
        job.latch = DeliveryLatch::create(wake_);
        job.deadline_ns = monotonic_now_ns() + job.timeout_ns;
        publish(*job.ready, job.latch);
        job.ready.reset();
        return wake_();
    }
    if (is_world_behind_ || !advance_world(job.target_ns)) return;
    clock_.hold(job.target_ns);
    auto done = std::move(job.done);
    steps_.pop_front();
    done(world_state());
    wake_();
}

void Rig::publish(const FrameSet& set, const std::shared_ptr<DeliveryLatch>& latch) {
    const TimeNs start_ns = monotonic_now_ns();
    bus_.publish(set, latch);
    publish_.record(monotonic_now_ns() - start_ns);
}

Pose Rig::pose_at(CameraEntry& entry, const Snapshot& snapshot) {
    const CameraSpec& spec = *entry.spec;
    if (!spec.mount) return spec.pose;
    const auto carrier = std::ranges::find_if(
        snapshot.movers, [&](const Instance& mover) { return mover.info->name == spec.mount->actor; });
    if (carrier != snapshot.movers.end()) entry.mount_frame = mount_frame(*carrier, spec.mount->node);
    return in_world(entry.mount_frame, spec.pose);
}

View Rig::view_of(const CameraEntry& entry, const LatestDue& latest) const {
    View view;
    view.camera = entry.id;
    view.name = entry.name;
    view.spec = latest.spec;
    view.spec_revision = latest.spec_revision;
    view.pose = latest.pose;
    view.quality = latest.spec->quality.value_or(options_.quality);
    view.sequence = latest.sequence;
    view.camera_number = entry.number;
    return view;
}

Rig::Drawing Rig::begin_instant(TimeNs world_ns, TimeNs monotonic_ns) {
    ++instants_;
    const TimeNs start_ns = monotonic_now_ns();
    Drawing drawing;
    drawing.snapshot = world_->snapshot(world_ns);
    drawing.monotonic_ns = monotonic_ns;
    world_time_.record(std::exchange(world_spent_ns_, 0) + monotonic_now_ns() - start_ns);

    for (const auto& due : schedule_.take(world_ns)) {
        CameraEntry& entry = cameras_.at(due.camera);
        std::vector<FrameRef> colors = std::move(entry.latest.colors);
        colors.clear();
        entry.latest = {entry.spec,
                        entry.spec_revision,
                        due.sequence,
                        world_ns,
                        monotonic_ns,
                        drawing.snapshot,
                        pose_at(entry, *drawing.snapshot),
                        std::move(colors)};
        PixelFormats formats = bus_.wanted(entry.id, world_ns);
        if (formats.empty()) {
            ++entry.idle;
            continue;
        }
        add_awaited(entry, world_ns, formats);
        View& view = drawing.views.emplace_back(view_of(entry, entry.latest));
        view.color_formats = made_of(view, formats);
    }
    return drawing;
}

FrameSet Rig::draw_some(Drawing& drawing, std::size_t count) {
    std::vector<View> views;
    std::vector<CameraEntry*> entries;
    for (; !drawing.is_done() && views.size() < count; ++drawing.drawn) {
        const View& view = drawing.views[drawing.drawn];
        CameraEntry* entry = cameras_.find_id(view.camera);
        if (!entry) continue;  // deleted meanwhile
        views.push_back(view);
        entries.push_back(entry);
    }
    const TimeNs start_ns = monotonic_now_ns();
    FrameSet set = draw(drawing.snapshot, drawing.monotonic_ns, views);
    if (!views.empty()) {
        const TimeNs cost_ns = (monotonic_now_ns() - start_ns) / static_cast<TimeNs>(views.size());
        view_cost_ns_ = std::max(TimeNs{1}, (3 * view_cost_ns_ + cost_ns) / 4);
    }
    for (std::size_t i = 0; i < views.size(); ++i) {
        LatestDue& latest = entries[i]->latest;
        const bool is_latest = latest.sequence == views[i].sequence;
        bool is_drawn = false;
        for (const FrameRef& frame : set.frames) {
            if (frame->info().camera_id != views[i].camera) continue;
            // What was drawn on demand before its turn is there twice.
            if (is_latest && !is_drawn) latest.colors.clear();
            is_drawn = true;
            if (is_latest) latest.colors.push_back(frame);
        }
        ++entries[i]->due;
        ++(is_drawn ? entries[i]->rendered : entries[i]->dropped);
    }
    return set;
}

FrameSet Rig::draw(const SnapshotRef& snapshot, TimeNs monotonic_ns, std::span<const View> views) {
    FrameSet nothing;
    nothing.world_ns = snapshot->world_ns;
    nothing.monotonic_ns = monotonic_ns;
    if (views.empty()) return nothing;

    const TimeNs start_ns = monotonic_now_ns();
    auto finished = renderer_->draw(snapshot, monotonic_ns, views);
    submit_.record(monotonic_now_ns() - start_ns);
    if (!finished) {
        for (const View& view : views) note_failure(cameras_.at(view.camera), finished.error());
        return nothing;
    }
    for (const auto& failure : finished->failures) note_failure(cameras_.at(failure.camera), failure.error);
    return std::move(finished->set);
}

void Rig::note_failure(const CameraEntry& entry, const Error& why) {
    const TimeNs now_ns = monotonic_now_ns();
    if (now_ns - last_failure_log_ns_ < ns_per_s) return;
    last_failure_log_ns_ = now_ns;
    spdlog::error("camera {}: could not be drawn: {}", *entry.name, why.message);
}

}  // namespace camrig
