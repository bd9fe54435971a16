#include "core/camera/exposure_times.h"

#include <algorithm>

#include "core/camera/clock_noise.h"

namespace camrig::camera {
namespace {

__extension__ typedef __int128 Int128;

// A period is period_num / period_den ns: den * 1e9 * 1e9 / (num * (1e9 + ppb)). Its products with a frame number and
// with a time stay below 2^124: frames * den is seconds * num, below 2^63, and 1e18 is below 2^60.
Int128 period_num(const Rate& rate) {
    return Int128{rate.den()} * ns_per_s * ns_per_s;
}
Int128 period_den(const Rate& rate, std::int64_t rate_ppb) {
    return Int128{rate.num()} * (ns_per_s + rate_ppb);
}

}  // namespace

ExposureTimes::ExposureTimes(const Rate& rate, const std::optional<ClockSpec>& clock) : rate_(rate) {
    if (!clock) return;
    phase_ns_ = clock->phase_ns;
    rate_ppb_ = clock->rate_ppb;
    most_late_ns_ = std::min(clock->trigger_jitter_ns, rate.period_ns() / 2);
    seed_ = most_late_ns_ > 0 ? clock->seed : 0;
}

TimeNs ExposureTimes::late_ns(std::int64_t n) const {
    if (most_late_ns_ == 0) return 0;
    return even_number(seed_, ClockNoise::trigger, static_cast<std::uint64_t>(n), 0, most_late_ns_);
}

TimeNs ExposureTimes::grid_time(std::int64_t n) const {
    CHECK(n >= 0);
    return phase_ns_ + static_cast<TimeNs>(n * period_num(rate_) / period_den(rate_, rate_ppb_));
}

std::int64_t ExposureTimes::first_on_grid(TimeNs t_ns) const {
    const TimeNs after_phase_ns = t_ns - phase_ns_;
    if (after_phase_ns <= 0) return 0;
    // floor(n * p) >= t  <=>  n * p >= t, because t is an integer.
    const Int128 num = period_num(rate_);
    return static_cast<std::int64_t>((after_phase_ns * period_den(rate_, rate_ppb_) + num - 1) / num);
}

TimeNs ExposureTimes::time_of_frame(std::int64_t n) const {
    if (is_rate_alone()) return rate_.time_of_frame(n);
    return grid_time(n) + late_ns(n);
}

std::int64_t ExposureTimes::first_frame_at_or_after(TimeNs t_ns) const {
    if (is_rate_alone()) return rate_.first_frame_at_or_after(t_ns);
    // The first that is late enough, or the next: no frame is late by more than half a period.
    const std::int64_t first = first_on_grid(t_ns - most_late_ns_);
    return time_of_frame(first) >= t_ns ? first : first + 1;
}

}  // namespace camrig::camera
