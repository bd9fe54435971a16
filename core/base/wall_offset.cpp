#include "core/base/wall_offset.h"

#include <cstdlib>

#include "core/base/clock.h"

namespace camrig {
namespace {

constexpr TimeNs clock_was_set_ns = 100 * ns_per_ms;

}  // namespace

TimeNs WallOffset::measured() {
    // Being preempted between the two clocks makes the offset wrong; the closest of some pairs is right.
    constexpr int tries = 8;
    TimeNs best_gap_ns = max_time_ns, offset_ns = 0;
    for (int i = 0; i < tries; ++i) {
        const TimeNs before_ns = monotonic_now_ns();
        const TimeNs real_ns = realtime_now_ns();
        const TimeNs gap_ns = monotonic_now_ns() - before_ns;
        if (gap_ns >= best_gap_ns) continue;
        best_gap_ns = gap_ns;
        offset_ns = real_ns - before_ns - gap_ns / 2;
    }
    return offset_ns;
}

TimeNs WallOffset::current() {
    const TimeNs now_ns = measure_();
    if (std::abs(now_ns - offset_ns_) > clock_was_set_ns) offset_ns_ = now_ns;
    return offset_ns_;
}

}  // namespace camrig
