#include "v4l2_sink/loopback/loopback_sink.h"

#include <algorithm>

#include "core/base/clock.h"
#include "core/stream/silence.h"

namespace camrig::device {

namespace {

std::span<const std::byte> picture_of(const stream::MediaUnit& unit) {
    if (unit.frame) return unit.frame->bytes();
    CHECK(unit.bytes != nullptr);
    return *unit.bytes;
}

}  // namespace

TimeNs LoopbackSink::repeated_ns(const stream::MediaUnit& unit, TimeNs monotonic_ns) const {
    const TimeNs clock_error_ns = unit.info.clock ? unit.info.clock->steady_error_ns : 0;
    return monotonic_ns - stream::repeat_age_ns(late_ns_) + std::min(TimeNs{0}, clock_error_ns);
}

Result<void> LoopbackSink::open(const stream::StreamInfo& info) {
    std::lock_guard lock(mutex_);
    stats_ = info.stats;
    return {};
}

void LoopbackSink::close() noexcept {
    std::lock_guard lock(mutex_);
    is_held_back_ = false;
}

void LoopbackSink::hold_back() {
    std::lock_guard lock(mutex_);
    is_held_back_ = true;
}

Result<void> LoopbackSink::write(const stream::MediaUnit& unit) {
    std::lock_guard lock(mutex_);
    is_held_back_ = false;
    if (!device_) {
        stats_->dropped.fetch_add(1, std::memory_order_relaxed);
        return {};
    }
    const TimeNs now_ns = monotonic_now_ns();
    const std::int64_t instant_us = std::min(unit.info.steady_ns(), now_ns) / ns_per_us;
    late_ns_ = now_ns - unit.info.monotonic_ns;
    if (const auto shown = show(unit, std::max(instant_us, last_stamp_us_ + 1), now_ns); !shown)
        return error(ErrorKind::internal, shown.error().message);  // not "unavailable", which the Output would retry
    stats_->delivered.fetch_add(1, std::memory_order_relaxed);
    stats_->bytes.fetch_add(picture_of(unit).size(), std::memory_order_relaxed);
    stats_->last_latency_ns.store(monotonic_now_ns() - unit.info.monotonic_ns, std::memory_order_relaxed);
    return {};
}

Result<void> LoopbackSink::show(const stream::MediaUnit& unit, std::int64_t stamp_us, TimeNs monotonic_ns) {
    if (auto shown = device_->show(picture_of(unit), stamp_us); !shown) return shown;
    last_ = unit;
    last_->latch.reset();
    last_stamp_us_ = stamp_us;
    last_show_ns_ = monotonic_ns;
    return {};
}

Result<void> LoopbackSink::refresh(const stream::MediaUnit& unit, TimeNs monotonic_ns) {
    std::lock_guard lock(mutex_);
    // A subscription was faster, or the world stands still: what is shown is as new.
    if (last_ && unit.info.sequence <= last_->info.sequence) return {};
    const bool is_recent = monotonic_ns - unit.info.monotonic_ns < silence_ns;
    const TimeNs instant_ns =
        is_recent ? std::min(unit.info.steady_ns(), monotonic_ns) : repeated_ns(unit, monotonic_ns);
    return show(unit, std::max(instant_ns / ns_per_us, last_stamp_us_ + 1), monotonic_ns);
}

Result<void> LoopbackSink::repeat_if_silent(TimeNs monotonic_ns) {
    std::lock_guard lock(mutex_);
    if (!last_ || is_held_back_) return {};
    if (monotonic_ns - last_show_ns_ < stream::silence_ns(device_->format().rate, silence_ns)) return {};
    const std::int64_t stamp_us = repeated_ns(*last_, monotonic_ns) / ns_per_us;
    return show(*last_, std::max(stamp_us, last_stamp_us_ + 1), monotonic_ns);
}

void LoopbackSink::give_up() {
    std::lock_guard lock(mutex_);
    device_.reset();
}

bool LoopbackSink::has_picture() const {
    std::lock_guard lock(mutex_);
    return last_.has_value();
}

}  // namespace camrig::device
