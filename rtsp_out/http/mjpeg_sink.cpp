#include "rtsp_out/http/mjpeg_sink.h"

#include <utility>

#include "core/base/clock.h"

namespace camrig {

Result<void> MjpegSink::open(const StreamInfo& info) {
    CHECK(info.stats != nullptr);
    std::lock_guard lock(mutex_);
    stats_ = info.stats;
    return {};
}

Result<void> MjpegSink::write(const MediaUnit& unit) {
    std::optional<InFlight> replaced;
    {
        std::lock_guard lock(mutex_);
        CHECK(stats_ != nullptr && unit.bytes != nullptr);
        if (abandoned_ || ended_) {
            stats_->dropped.fetch_add(1, std::memory_order_relaxed);
            return {};
        }
        replaced = std::exchange(slot_, InFlight{unit, unit.latch ? unit.latch->hold(who_) : DeliveryLatch::Hold{}});
        if (replaced) stats_->dropped.fetch_add(1, std::memory_order_relaxed);
    }
    bell_->ring();
    return {};
}

void MjpegSink::close() noexcept {
    {
        std::lock_guard lock(mutex_);
        ended_ = true;
    }
    bell_->ring();
}

std::optional<MjpegSink::InFlight> MjpegSink::take() {
    std::lock_guard lock(mutex_);
    return std::exchange(slot_, std::nullopt);
}

bool MjpegSink::ended() const {
    std::lock_guard lock(mutex_);
    return ended_;
}

void MjpegSink::sent(InFlight&& item, std::size_t bytes) {
    const InFlight done = std::move(item);  // its hold goes last, when the books are right
    std::lock_guard lock(mutex_);
    stats_->delivered.fetch_add(1, std::memory_order_relaxed);
    stats_->bytes.fetch_add(bytes, std::memory_order_relaxed);
    stats_->last_latency_ns.store(monotonic_now_ns() - done.unit.info.monotonic_ns, std::memory_order_relaxed);
}

void MjpegSink::dropped(InFlight&& item) {
    const InFlight done = std::move(item);
    std::lock_guard lock(mutex_);
    stats_->dropped.fetch_add(1, std::memory_order_relaxed);
}

void MjpegSink::abandon() {
    std::optional<InFlight> waiting;
    std::lock_guard lock(mutex_);
    abandoned_ = true;
    waiting = std::exchange(slot_, std::nullopt);
    if (waiting) stats_->dropped.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace camrig
