#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "core/stream/sink.h"
#include "v4l2_sink/loopback/device.h"

namespace camrig::device {

/// Writes the pictures of one camera into one loopback device, and keeps the device alive while none come.
///
/// Stamps are the instant a picture shows, in microseconds of CLOCK_MONOTONIC: the same for all cameras of an instant,
/// strictly rising, never in the future (GStreamer distrusts a device for good after one bad stamp).
///
/// Sink side: the Output's thread. The rest: the loopback host's thread. A mutex makes them take turns at the device.
class LoopbackSink final : public stream::Sink {
public:
    /// How long a device may stay silent: below the 2 s that are promised, so that a program that waits 5 s (ROS
    /// usb_cam) or 10 s (OpenCV) never gives up.
    static constexpr TimeNs silence_ns = 1'500 * ns_per_ms;
    /// A repeated picture is stamped so far in the past: the camera's next one, drawn meanwhile, is never older.
    static constexpr TimeNs repeat_age_ns = 500 * ns_per_ms;

    explicit LoopbackSink(std::unique_ptr<LoopbackDevice> device) : device_(std::move(device)) {}

    Result<void> open(const stream::StreamInfo& info) override;
    /// A failed write ends the subscription; the host opens the device anew.
    Result<void> write(const stream::MediaUnit& unit) override;
    void close() noexcept override {}

    /// A picture that was fetched while nobody reads, so that the next reader's first one is not old.
    Result<void> refresh(const stream::MediaUnit& unit, TimeNs monotonic_ns);
    /// Shows the last picture again if the device was silent for too long. In lockstep only with `idle` (nobody reads):
    /// a reader gets the pictures that were asked for and no other.
    Result<void> repeat_if_silent(TimeNs monotonic_ns, bool idle);
    bool has_picture() const;

    /// Calls `use` with the device, while nothing is written to it. Not after give_up().
    auto with_device(auto use) {
        std::lock_guard lock(mutex_);
        return use(*device_);
    }
    /// Closes the device, whoever still has the sink; what comes after is dropped.
    void give_up();

private:
    Result<void> show(const stream::MediaUnit& unit, std::int64_t stamp_us, TimeNs monotonic_ns);

    mutable std::mutex mutex_;
    std::unique_ptr<LoopbackDevice> device_;  ///< null after give_up()
    std::shared_ptr<stream::ReaderStats> stats_;
    std::optional<stream::MediaUnit> last_;
    std::int64_t last_stamp_us_ = 0;
    TimeNs last_show_ns_ = 0;
    bool in_lockstep_ = false;
};

}  // namespace camrig::device
