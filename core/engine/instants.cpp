#include "core/engine/instants.h"

#include <algorithm>

#include "core/base/clock.h"
#include "core/engine/failing_pictures.h"

namespace camrig::engine {
namespace {

/// Policy slow: how late a picture may be before the world waits.
constexpr TimeNs slow_tolerance_ns = 20 * ns_per_ms;
constexpr std::size_t max_queued_steps = 64;
constexpr std::size_t max_dropped_at = 1024;

}  // namespace

Instants::~Instants() {
    for (auto& step : steps_) step.done(error(ErrorKind::unavailable, "the rig shuts down"));
}

TimeNs Instants::wake_time_ns() const {
    if (world_.is_behind()) return 0;
    if (rig_.clock.running()) {
        // Policy slow waits for what is drawn, and hears of it.
        if (rig_.options.overload == OverloadPolicy::slow && !rig_.drawing->is_idle()) return max_time_ns;
        const TimeNs idle_ns = monotonic_now_ns() + idle_tick_ns;
        const TimeNs next_ns = std::min(rig_.schedule.next_due_ns(), rig_.agenda.next_ns());
        // What is beyond the limit comes when that is raised.
        return next_ns == max_time_ns || next_ns > rig_.agenda.limit_ns()
                   ? idle_ns
                   : std::min(idle_ns, rig_.clock.monotonic_at(next_ns));
    }
    if (steps_.empty()) return max_time_ns;
    const StepJob& job = steps_.front();
    // What is on its way and what is drawn are heard of; only a delivery has an end of its own.
    if (job.latch && !job.latch->is_open()) return job.deadline_ns;
    return job.next && !rig_.drawing->is_idle() ? max_time_ns : 0;
}

void Instants::turn(TimeNs monotonic_ns) {
    world_.rest();
    if (rig_.clock.running())
        run_realtime(monotonic_ns);
    else
        advance_step(monotonic_ns);
}

void Instants::run_realtime(TimeNs monotonic_ns) {
    const bool waits = rig_.options.overload == OverloadPolicy::slow;
    if (waits && !rig_.drawing->is_idle()) return;
    const TimeNs next_ns = rig_.schedule.next_due_ns();
    const TimeNs now_ns = std::min(rig_.clock.world_at(monotonic_ns), rig_.agenda.gate_ns());
    if (next_ns > now_ns) {
        chosen_late_ns_.reset();
        world_.advance(now_ns);
        return;
    }
    if (!chosen_late_ns_) {
        chosen_late_ns_ = now_ns - next_ns;
        wakeup_time_.record(*chosen_late_ns_);
        if (!waits)
            account_skipped(rig_.schedule.choose_instant(now_ns));
        else if (*chosen_late_ns_ > slow_tolerance_ns)
            rig_.clock.run(next_ns + slow_tolerance_ns, monotonic_ns);
    }
    const TimeNs instant_ns = rig_.schedule.next_due_ns();
    rig_.done_ns = std::max(rig_.done_ns, instant_ns);
    if (!world_.advance(instant_ns)) return;
    begin_instant(instant_ns, rig_.clock.monotonic_at(instant_ns), !waits);
    chosen_late_ns_.reset();
}

void Instants::account_skipped(TimeNs instant_ns) {
    constexpr std::int64_t max_counted_one_by_one = 4096;
    std::set<TimeNs> instants;
    std::int64_t most = 0;
    for (const auto& skipped : rig_.schedule.skip_before(instant_ns)) {
        CameraEntry& entry = rig_.cameras.at(skipped.camera);
        const auto frames = static_cast<std::uint64_t>(skipped.frames);
        const auto reason =
            skipped.first_ns <= rig_.held_until_ns ? stream::DropReason::held : stream::DropReason::overload;
        const camera::ExposureTimes times = entry.exposure_times();
        const std::int64_t first = times.first_frame_at_or_after(skipped.first_ns);
        const TimeNs last_ns = times.time_of_frame(first + (skipped.frames - 1) * skipped.stride);
        const std::uint64_t missed = rig_.bus.miss(entry.id, {skipped.first_ns, last_ns, frames}, reason);
        entry.due += missed;
        entry.dropped[static_cast<std::size_t>(reason)] += missed;
        entry.idle += frames - missed;
        for (std::int64_t i = 0; i < std::min(skipped.frames, max_counted_one_by_one); ++i)
            instants.insert(times.time_of_frame(first + i * skipped.stride));
        most = std::max(most, skipped.frames);
    }
    const auto count = std::max(static_cast<std::uint64_t>(most), static_cast<std::uint64_t>(instants.size()));
    instants_ += count;
    dropped_instants_ += count;
}

bool Instants::has_reached(TimeNs world_ns, TimeNs monotonic_ns) const {
    if (rig_.schedule.next_due_ns() <= world_ns || rig_.world->last_step_ns() < world_ns) return false;
    if (rig_.clock.running())
        return !chosen_late_ns_ && std::min(rig_.clock.world_at(monotonic_ns), rig_.agenda.limit_ns()) >= world_ns;
    if (rig_.clock.world_at(0) >= world_ns) return true;
    return !steps_.empty() && steps_.front().target_ns >= world_ns && !steps_.front().next;
}

void Instants::begin_instant(TimeNs world_ns, TimeNs monotonic_ns, bool may_be_dropped) {
    ++instants_;
    rig_.done_ns = std::max(rig_.done_ns, world_ns);
    rig_.bus.reader_log().begin_instant(world_ns);
    const TimeNs start_ns = monotonic_now_ns();
    DueViews due;
    due.snapshot = rig_.world->snapshot(world_ns);
    due.monotonic_ns = monotonic_ns;
    due.may_be_dropped = may_be_dropped;
    world_time_.record(world_.take_spent_ns() + monotonic_now_ns() - start_ns);

    const std::shared_ptr<const world::WorldPast> past = rig_.world_past(world_ns);
    for (const auto& next : rig_.schedule.take(world_ns)) {
        CameraEntry& entry = rig_.cameras.at(next.camera);
        rig_.show(entry, next.sequence, due.snapshot, monotonic_ns, past);
        // An event may have given it another clock.
        if (const camera::ExposureTimes times = entry.exposure_times(); times != rig_.schedule.times(entry.id))
            rig_.schedule.set(entry.id, times, world_ns, rig_.schedule.next_sequence(entry.id));
        // The next one's exposure begins when this one's is over.
        const auto& sensor = entry.spec().sensor;
        rig_.schedule.set_stride(
            entry.id, sensor ? sensor->periods_of(entry.sensor->longest_ahead_s(*sensor), entry.spec().rate) : 1);
        if (rig_.cameras.follow_outputs(entry, world_ns)) {
            rig_.bus.change_camera(stream_of(entry));
            rig_.bus.adjust_camera(stream_of(entry));
        }
        frame::PixelFormats formats = rig_.bus.wanted(entry.id, world_ns);
        if (formats.empty()) {
            ++entry.idle;
            continue;
        }
        if (entry.latest.is_dropped()) {
            miss(entry, world_ns, stream::DropReason::fault);
            continue;
        }
        requests_.add_awaited(entry, world_ns, formats);
        DueViews picture = rig_.picture_of(entry);
        render::View& view = picture.views.front();
        rig_.ask_for(view, formats);
        if (picture.snapshot == due.snapshot) {
            due.views.push_back(std::move(view));
        } else {
            picture.may_be_dropped = may_be_dropped;
            rig_.drawing->add(picture);
        }
    }
    rig_.drawing->add(due);
}

void Instants::miss(CameraEntry& entry, TimeNs world_ns, stream::DropReason reason) {
    ++entry.due;
    ++entry.dropped[static_cast<std::size_t>(reason)];
    rig_.bus.miss(entry.id, {world_ns, world_ns, 1}, reason);
    if (reason == stream::DropReason::fault) return;
    entry.not_drawn.emplace_back(world_ns, reason);
    if (entry.not_drawn.size() > CameraEntry::max_not_drawn) entry.not_drawn.pop_front();
}

void Instants::forget_damage(CameraEntry& entry, const render::View& view, std::span<frame::FrameRef> frames) {
    for (frame::FrameRef& frame : frames) {
        const frame::FrameInfo& drawn = frame->info();
        const std::int64_t base = drawn.damage.base().value_or(max_time_ns);
        if (view.failing) {
            entry.altered_sequence = std::max(entry.altered_sequence, drawn.sequence);
        } else if (base <= entry.altered_sequence) {
            frame::FrameInfo info = drawn;
            info.damage = {};
            frame = std::make_shared<const frame::Frame>(std::move(info), frame);
        }
    }
}

void Instants::drawn(DrawnViews& drawn) {
    frame::FrameSet set;
    set.world_ns = shown_ns(drawn.due.views.front(), *drawn.due.snapshot);
    set.monotonic_ns = drawn.due.monotonic_ns;
    for (const auto& failure : drawn.failures) {
        if (const CameraEntry* entry = rig_.cameras.find_id(failure.camera))
            rig_.note_failure(*entry->name, failure.error);
    }
    for (const render::View& view : drawn.due.views) {
        CameraEntry* entry = rig_.cameras.find_id(view.camera);
        if (entry == nullptr) continue;  // deleted meanwhile
        const std::span<frame::FrameRef> frames = std::ranges::equal_range(
            drawn.frames, view.camera, {}, [](const frame::FrameRef& frame) { return frame->info().camera_id; });
        if (frames.empty()) {
            miss(*entry, set.world_ns, stream::DropReason::failure);
            continue;
        }
        ++entry->due;
        ++entry->rendered;
        forget_damage(*entry, view, frames);
        requests_.colors_drawn(*entry, frames);
        rig_.cameras.keep_colors(*entry, view, frames);
        set.frames.insert(set.frames.end(), frames.begin(), frames.end());
    }
    if (drawn.due.may_be_dropped || !rig_.step_instant_ns || *rig_.step_instant_ns != set.world_ns)
        return rig_.publish(set, nullptr);
    auto& next = steps_.front().next->frames;
    next.insert(next.end(), set.frames.begin(), set.frames.end());
}

void Instants::dropped(const DueViews& due, const render::View& view, stream::DropReason reason) {
    CameraEntry* entry = rig_.cameras.find_id(view.camera);
    if (entry == nullptr) return;
    const TimeNs world_ns = shown_ns(view, *due.snapshot);
    miss(*entry, world_ns, reason);
    if (!dropped_at_.insert(world_ns).second) return;
    ++dropped_instants_;
    if (dropped_at_.size() > max_dropped_at) dropped_at_.erase(dropped_at_.begin());
}

void Instants::advance_step(TimeNs monotonic_ns) {
    if (steps_.empty()) return;
    StepJob& job = steps_.front();
    // The next instant is drawn while the last one is on its way; it is published when that has arrived.
    const TimeNs next_ns = rig_.schedule.next_due_ns();
    // Commands that wait for their time have it on the way.
    const TimeNs reach_ns = std::min(job.target_ns, rig_.agenda.next_ns());
    if (!job.next && next_ns <= reach_ns && world_.advance(next_ns)) {
        const TimeNs now_ns = monotonic_now_ns();
        job.next = frame::FrameSet{next_ns, now_ns, {}};
        rig_.step_instant_ns = next_ns;
        begin_instant(next_ns, now_ns, false);
    }

    if (job.latch && !job.latch->is_open()) {
        if (monotonic_ns >= job.deadline_ns) give_up_step(monotonic_ns);
        return;
    }
    if (job.next) {
        if (!rig_.drawing->is_idle()) return;
        frame::FrameSet ready = std::move(*job.next);
        job.next.reset();
        rig_.step_instant_ns.reset();
        std::ranges::stable_sort(ready.frames, {},
                                 [](const frame::FrameRef& frame) { return frame->info().camera_id; });
        rig_.clock.hold(ready.world_ns);
        job.latch = stream::DeliveryLatch::create(rig_.wake);
        job.deadline_ns = monotonic_now_ns() + job.timeout_ns;
        rig_.publish(ready, job.latch);
        return rig_.wake();
    }
    if (world_.is_behind() || !world_.advance(reach_ns) || reach_ns < job.target_ns) return;
    rig_.clock.hold(job.target_ns);
    const StepJob ended = std::move(job);
    steps_.pop_front();
    ended.done(ended.state());
    rig_.wake();
}

void Instants::give_up_step(TimeNs monotonic_ns) {
    rig_.drawing->finish();  // what is drawn still comes to the step
    StepJob job = std::move(steps_.front());
    std::string laggards;
    for (const auto& who : job.latch->holders()) laggards += (laggards.empty() ? "" : "; ") + who;
    rig_.clock.hold(rig_.world_now_ns(monotonic_ns));
    rig_.step_instant_ns.reset();
    job.done(error(ErrorKind::unavailable,
                   "the step waits for " + laggards.substr(0, 500) + " since " +
                       std::to_string(job.timeout_ns / ns_per_ms) + " ms and was given up at world time " +
                       std::to_string(rig_.clock.world_at(0)) + " ns; close that reader or give a longer timeout_s"));
    if (job.next) rig_.publish(*job.next, nullptr);
    steps_.pop_front();
    // In the log of commands stands the whole step.
    if (steps_.empty() && rig_.options.journal)
        rig_.options.journal->note(rig_.clock.world_at(0), R"({"method":"world.step","params":{}})", true);
    rig_.wake();
}

bool Instants::start_step(Request<StepWorld>& request, std::function<WorldState()> state) {
    if (rig_.clock.running()) {
        request.done(error(ErrorKind::unavailable,
                           "the world runs in real time; pause it first, or start with --mode lockstep"));
        return false;
    }
    if (steps_.size() >= max_queued_steps) {
        request.done(
            error(ErrorKind::resource_exhausted, std::to_string(max_queued_steps) + " steps are waiting; send slower"));
        return false;
    }
    const StepWorld& step = request.command;
    const TimeNs from_ns = steps_.empty() ? rig_.clock.world_at(0) : steps_.back().target_ns;
    if (step.duration_ns < 0 || step.duration_ns > max_time_ns - from_ns) {
        request.done(error(ErrorKind::invalid_argument, "a step must be from 0 ns and end before 146 years"));
        return false;
    }
    StepJob job;
    job.target_ns = from_ns + step.duration_ns;
    job.timeout_ns = step.timeout_ns;
    job.done = std::move(request.done);
    job.state = std::move(state);
    steps_.push_back(std::move(job));
    rig_.wake();
    return true;
}

void Instants::begin_world() {
    chosen_late_ns_.reset();
    dropped_at_.clear();
}

void Instants::fill_report(stream::RigReport& report) const {
    report.instants = instants_;
    report.dropped_instants = dropped_instants_;
    report.stages.push_back({"wakeup", wakeup_time_.summary()});
    report.stages.push_back({"world", world_time_.summary()});
}

}  // namespace camrig::engine
