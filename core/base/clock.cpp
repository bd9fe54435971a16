#include "core/base/clock.h"

#include <ctime>

namespace camrig {
namespace {

TimeNs read_clock(clockid_t id) {
    timespec now{};
    clock_gettime(id, &now);
    return static_cast<TimeNs>(now.tv_sec) * ns_per_s + now.tv_nsec;
}

}  // namespace

TimeNs monotonic_now_ns() {
    return read_clock(CLOCK_MONOTONIC);
}
TimeNs realtime_now_ns() {
    return read_clock(CLOCK_REALTIME);
}
TimeNs thread_cpu_ns() {
    return read_clock(CLOCK_THREAD_CPUTIME_ID);
}

}  // namespace camrig
