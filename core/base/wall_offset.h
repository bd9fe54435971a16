#pragma once

#include <functional>
#include <utility>

#include "core/base/time.h"

namespace camrig {

/// CLOCK_REALTIME minus CLOCK_MONOTONIC, one value for all streams of a server, so that all of them give an instant
/// the same absolute time.
///
/// Measured once, and again only when the real time clock was set (by more than a tenth of a second). One thread.
class WallOffset {
public:
    /// `measure` gives the present difference of the clocks; by default this machine's.
    explicit WallOffset(std::function<TimeNs()> measure = measured)
        : measure_(std::move(measure)), offset_ns_(measure_()) {}
    TimeNs current();

private:
    static TimeNs measured();

    std::function<TimeNs()> measure_;
    TimeNs offset_ns_;
};

}  // namespace camrig
