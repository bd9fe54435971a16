#include "core/camera/clock.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/camera/clock_noise.h"

namespace camrig::camera {
namespace {

__extension__ typedef __int128 Int128;

/// How well a clock is kept by what keeps it, and how often it is looked at.
struct Keeping {
    TimeNs most_ns = 0;
    TimeNs period_ns = 1;
};
/// NTP in a local network is right within 0.1 to 1 ms, polled every 64 s (RFC 5905); PTP with stamps in hardware within
/// 1 us, once a second (IEEE 1588, default profile).
constexpr Keeping kept_by_ntp{500 * ns_per_us, 64 * ns_per_s};
constexpr Keeping kept_by_ptp{500, ns_per_s};
/// A crystal whose last correction is kept is wrong by what temperature does to it.
constexpr std::int64_t least_holdover_ppb = 100, most_holdover_ppb = 1000;
constexpr TimeNs set_from_ns = ns_per_s;      ///< a clock that is wrong by more is set
constexpr std::int64_t slew_divisor = 2'000;  ///< 500 ppm

bool is_kept(ClockState state) {
    return state == ClockState::ntp || state == ClockState::ptp || state == ClockState::tai;
}

/// floor(ns * ppb / 1e9).
TimeNs scaled(TimeNs ns, std::int64_t ppb) {
    const Int128 product = Int128{ns} * ppb;
    return static_cast<TimeNs>(product / ns_per_s - (product % ns_per_s < 0 ? 1 : 0));
}

TimeNs kept_error_ns(const ClockSpec& spec, TimeNs world_ns) {
    const Keeping& keeping = spec.state == ClockState::ntp ? kept_by_ntp : kept_by_ptp;
    return wander_ns(spec.seed, world_ns, keeping.period_ns, keeping.most_ns);
}

std::int64_t holdover_ppb(const ClockSpec& spec) {
    const auto size = even_number(spec.seed, ClockNoise::holdover, 0, least_holdover_ppb, most_holdover_ppb);
    return even_number(spec.seed, ClockNoise::holdover, 1, 0, 1) == 0 ? -size : size;
}

/// What is left of an error after so long a time of slewing.
TimeNs slewed(TimeNs error_ns, TimeNs since_ns) {
    const TimeNs done_ns = since_ns / slew_divisor;
    return error_ns < 0 ? std::min<TimeNs>(0, error_ns + done_ns) : std::max<TimeNs>(0, error_ns - done_ns);
}

}  // namespace

Clock::Clock(const std::optional<ClockSpec>& spec) : segments_{{.begin_ns = 0, .since_ns = 0, .spec = spec}} {
    if (spec && spec->state == ClockState::ptp_lost) segments_.front().carried_ns = kept_error_ns(*spec, 0);
}

TimeNs Clock::error_ns(const Segment& segment, TimeNs world_ns) {
    const ClockSpec& spec = *segment.spec;
    const TimeNs since_ns = world_ns - segment.since_ns;
    if (is_kept(spec.state)) {
        const TimeNs told_ns = spec.state == ClockState::tai ? tai_minus_utc_ns : 0;
        return spec.offset_ns + told_ns + kept_error_ns(spec, world_ns) + slewed(segment.carried_ns, since_ns);
    }
    if (spec.state == ClockState::ptp_lost)
        return spec.offset_ns + segment.carried_ns + scaled(since_ns, holdover_ppb(spec));
    return spec.offset_ns + segment.carried_ns + scaled(since_ns, spec.drift_ppb) +
           walk_ns(spec.seed, world_ns, spec.walk_ns);
}

std::int64_t Clock::drift_ppb(const Segment& segment, TimeNs world_ns) {
    const ClockSpec& spec = *segment.spec;
    if (spec.state == ClockState::ptp_lost) return holdover_ppb(spec);
    if (!is_kept(spec.state)) return spec.drift_ppb;
    const TimeNs left_ns = slewed(segment.carried_ns, world_ns - segment.since_ns);
    constexpr std::int64_t slew_ppb = ns_per_s / slew_divisor;
    return left_ns == 0 ? 0 : left_ns > 0 ? -slew_ppb : slew_ppb;
}

Clock::Segment Clock::following(const Segment& before, const std::optional<ClockSpec>& spec, TimeNs begin_ns) {
    if (!spec || !before.spec) {
        Segment fresh = Clock(spec).segments_.front();
        fresh.begin_ns = begin_ns;
        return fresh;
    }
    const ClockSpec& old = *before.spec;
    Segment next = before;
    next.begin_ns = begin_ns;
    next.spec = spec;
    next.stepped_ns += spec->offset_ns - old.offset_ns;
    const bool runs_on = spec->state == old.state && spec->drift_ppb == old.drift_ppb && spec->walk_ns == old.walk_ns &&
                         spec->seed == old.seed;
    if (runs_on) return next;
    next.since_ns = begin_ns;
    next.carried_ns = 0;
    next.carried_ns = (error_ns(before, begin_ns) - old.offset_ns) - (error_ns(next, begin_ns) - spec->offset_ns);
    if (is_kept(spec->state) && std::abs(next.carried_ns) > set_from_ns) {
        next.stepped_ns -= next.carried_ns;
        next.carried_ns = 0;
    }
    return next;
}

void Clock::set(const std::optional<ClockSpec>& spec, TimeNs begin_ns) {
    const auto later = std::ranges::upper_bound(segments_, begin_ns, {}, &Segment::begin_ns);
    const Segment& before = later == segments_.begin() ? segments_.front() : *std::prev(later);
    Segment next = following(before, spec, begin_ns);
    std::erase_if(segments_, [&](const Segment& one) { return one.begin_ns >= begin_ns; });
    segments_.push_back(std::move(next));
    // The second must have begun before what is kept, or the first is still needed.
    while (segments_.size() > max_segments || (segments_.size() > 1 && segments_[1].begin_ns <= begin_ns - kept_ns))
        segments_.erase(segments_.begin());
}

std::optional<ClockReading> Clock::at(TimeNs world_ns, TimeNs apart_ns) const {
    const auto next = std::ranges::upper_bound(segments_, world_ns, {}, &Segment::begin_ns);
    const Segment& segment = next == segments_.begin() ? *next : *std::prev(next);
    if (!segment.spec) return std::nullopt;
    const ClockSpec& spec = *segment.spec;
    const TimeNs error = error_ns(segment, world_ns);
    const TimeNs jitter =
        bell_number(spec.seed, ClockNoise::jitter, static_cast<std::uint64_t>(world_ns), spec.jitter_ns);
    // Drift and slewing shorten the time between two pictures by less than the fiftieth that is left.
    const TimeNs most = apart_ns / 100 * 49;
    return ClockReading{.stamp_error_ns = error + jitter + (world_ns >= spec.step_at_ns ? spec.step_ns : 0),
                        .steady_error_ns = error + std::clamp(jitter, -most, most) - segment.stepped_ns,
                        .drift_ppb = drift_ppb(segment, world_ns)};
}

}  // namespace camrig::camera
