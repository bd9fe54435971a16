#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "core/stream/sink.h"
#include "v4l2_sink/loopback/device.h"

namespace camrig::device {

/// Writes the pictures of one camera into one loopback device, and repeats the last one while none come.
///
/// A picture's timestamp is the instant that it shows, in microseconds of CLOCK_MONOTONIC: equal for all cameras of an
/// instant, strictly increasing, never in the future (after one bad timestamp GStreamer ignores those of the device for
/// good).
///
/// Sink calls: the Output's thread. The rest: the loopback host's thread. A mutex guards the device.
class LoopbackSink final : public stream::Sink {
public:
    /// How long a device may stay silent, unless its camera is slower than that: below the 2 s that are promised, so
    /// that a program that waits 5 s (ROS usb_cam) or 10 s (OpenCV) never gives up.
    static constexpr TimeNs silence_ns = 1'500 * ns_per_ms;

    explicit LoopbackSink(std::unique_ptr<LoopbackDevice> device) : device_(std::move(device)) {}

    Result<void> open(const stream::StreamInfo& info) override;
    /// A failed write ends the subscription (error internal); the host then reopens the device.
    Result<void> write(const stream::MediaUnit& unit) override;
    void close() noexcept override;
    void hold_back() override;

    /// Shows a picture that was fetched while nobody reads and the camera is not subscribed to, so that the next
    /// reader's first picture is a recent one.
    Result<void> refresh(const stream::MediaUnit& unit, TimeNs monotonic_ns);
    /// Shows the last picture again if the device was silent for too long.
    Result<void> repeat_if_silent(TimeNs monotonic_ns);
    bool has_picture() const;

    /// Calls `use` with the device, while nothing is written to it. Not after give_up().
    auto with_device(auto use) {
        std::lock_guard lock(mutex_);
        return use(*device_);
    }
    /// Closes the device, although the bus may still hold the sink; later pictures are dropped.
    void give_up();

private:
    /// What a picture is stamped with that is shown again: by its camera's clock, or the next one would seem to come
    /// before it. Never in the future.
    TimeNs repeated_ns(const stream::MediaUnit& unit, TimeNs monotonic_ns) const;
    Result<void> show(const stream::MediaUnit& unit, std::int64_t stamp_us, TimeNs monotonic_ns);

    mutable std::mutex mutex_;
    std::unique_ptr<LoopbackDevice> device_;  ///< null after give_up()
    std::shared_ptr<stream::ReaderStats> stats_;
    std::optional<stream::MediaUnit> last_;
    std::int64_t last_stamp_us_ = 0;
    TimeNs last_show_ns_ = 0;
    TimeNs late_ns_ = 0;         ///< how long after its instant the last new picture came
    bool is_held_back_ = false;  ///< a fault withholds pictures at present
};

}  // namespace camrig::device
