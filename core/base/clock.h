#pragma once

#include "core/base/time.h"

namespace camrig {

/// CLOCK_MONOTONIC now, in ns.
TimeNs monotonic_now_ns();
/// CLOCK_REALTIME now, in ns since 1970.
TimeNs realtime_now_ns();

/// CPU time that the calling thread has taken so far, in ns (CLOCK_THREAD_CPUTIME_ID).
TimeNs thread_cpu_ns();

}  // namespace camrig
