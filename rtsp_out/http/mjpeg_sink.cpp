#include "rtsp_out/http/mjpeg_sink.h"

#include <utility>

#include "core/base/clock.h"

namespace camrig::http {

Result<void> MjpegSink::open(const stream::StreamInfo& info) {
    CHECK(info.stats != nullptr);
    stats_ = info.stats;
    return {};
}

Result<void> MjpegSink::write(const stream::MediaUnit& unit) {
    CHECK(stats_ != nullptr && unit.bytes != nullptr);
    is_held_back_ = false;
    const auto without_place =
        is_ended_ ? std::optional<InFlight>(InFlight{}) : slot_.put({unit, hold_if(unit.latch, who_)});
    if (without_place) stats_->dropped.fetch_add(1, std::memory_order_relaxed);
    return {};
}

void MjpegSink::close() noexcept {
    is_ended_ = true;
    event_->set();
}

void MjpegSink::hold_back() {
    is_held_back_ = true;
}

void MjpegSink::sent(InFlight&& item, std::size_t bytes) {
    const InFlight done = std::move(item);  // its hold goes last, when the books are right
    stats_->delivered.fetch_add(1, std::memory_order_relaxed);
    stats_->bytes.fetch_add(bytes, std::memory_order_relaxed);
    stats_->last_latency_ns.store(monotonic_now_ns() - done.unit.info.monotonic_ns, std::memory_order_relaxed);
}

void MjpegSink::dropped(InFlight&& item) {
    const InFlight done = std::move(item);
    stats_->dropped.fetch_add(1, std::memory_order_relaxed);
}

void MjpegSink::abandon() {
    if (const auto waiting = slot_.close()) stats_->dropped.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace camrig::http
