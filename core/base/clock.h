#pragma once

#include "core/base/time.h"

namespace camrig {

/// CLOCK_MONOTONIC now, in ns.
TimeNs monotonic_now_ns();
/// CLOCK_REALTIME now, in ns since 1970.
TimeNs realtime_now_ns();

}  // namespace camrig
