#pragma once

#include <cstdint>
#include <optional>

#include "core/base/rate.h"
#include "core/camera/clock_spec.h"

namespace camrig::camera {

/// When a camera exposes: the grid of its rate from world time 0, moved by the phase, rate error and trigger jitter of
/// its clock. Without them frame n is due when Rate says.
///
/// Frame n is due at phase + floor(n / (rate * (1 + rate_ppb / 1e9))) + late(n), exact in 128-bit integers for every
/// time below max_time_ns; late(n) is a random number of n alone. Due times strictly rise.
class ExposureTimes {
public:
    ExposureTimes() = default;
    ExposureTimes(const Rate& rate, const std::optional<ClockSpec>& clock = std::nullopt);

    /// World time at which frame n (>= 0) is due.
    TimeNs time_of_frame(std::int64_t n) const;
    /// The least time from one frame to the next.
    TimeNs least_apart_ns() const { return rate_.period_ns() - rate_.period_ns() / 500 - most_late_ns_; }
    /// The smallest n >= 0 with time_of_frame(n) >= t_ns.
    std::int64_t first_frame_at_or_after(TimeNs t_ns) const;
    /// The number of the first frame after t_ns.
    std::int64_t frames_until(TimeNs t_ns) const { return first_frame_at_or_after(t_ns + 1); }

    friend bool operator==(const ExposureTimes&, const ExposureTimes&) = default;

private:
    bool is_rate_alone() const { return phase_ns_ == 0 && rate_ppb_ == 0 && most_late_ns_ == 0; }
    TimeNs grid_time(std::int64_t n) const;
    std::int64_t first_on_grid(TimeNs t_ns) const;
    TimeNs late_ns(std::int64_t n) const;

    Rate rate_;
    TimeNs phase_ns_ = 0;
    std::int64_t rate_ppb_ = 0;
    TimeNs most_late_ns_ = 0;
    std::uint64_t seed_ = 0;
};

}  // namespace camrig::camera
