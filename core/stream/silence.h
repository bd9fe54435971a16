#pragma once

#include <algorithm>

#include "core/base/rate.h"

namespace camrig::stream {

/// How long nothing comes before a sink shows its last picture once more, so that programs with time limits live on
/// while the world stands still: no less than two periods, or a slow camera would seem to send twice.
inline TimeNs silence_ns(const Rate& rate, TimeNs least_ns) {
    return std::max(least_ns, 2 * rate.period_ns());
}

}  // namespace camrig::stream
