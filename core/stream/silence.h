#pragma once

#include <algorithm>

#include "core/base/rate.h"

namespace camrig::stream {

/// How long nothing comes before a sink shows its last picture once more, so that programs with time limits live on
/// while the world stands still: no less than two periods, or a slow camera would seem to send twice.
inline TimeNs silence_ns(const Rate& rate, TimeNs least_ns) {
    return std::max(least_ns, 2 * rate.period_ns());
}

inline constexpr TimeNs least_repeat_age_ns = ns_per_s / 2;

/// How far in the past a picture is stamped that is shown once more, if the last new one came `late_ns` after its
/// instant: so far that the next one, which may be on its way, has its own instant later.
inline TimeNs repeat_age_ns(TimeNs late_ns) {
    return std::max(least_repeat_age_ns, 2 * late_ns);
}

}  // namespace camrig::stream
