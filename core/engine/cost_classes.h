#pragma once

#include <array>
#include <vector>

#include "core/base/time.h"

namespace camrig::engine {

/// Divides cameras into classes of similar drawing time, with bounds about a factor of 4 apart. Each bound lies in the
/// middle of the widest gap between costs near it, so that cameras of nearly equal cost, which varies a little, are not
/// divided. Pure arithmetic: no clock, no threads.
class CostClasses {
public:
    static constexpr int count = 5;

    /// Sets the bounds from the present costs of all cameras, in any order. Reorders the vector.
    void divide(std::vector<TimeNs>& costs_ns);
    /// The class of this cost; 0 is the cheapest.
    int of(TimeNs cost_ns) const;

private:
    /// The lower bound of each class but the first, where no camera's cost is near it.
    static constexpr std::array<TimeNs, count - 1> usual_ns = {4 * ns_per_ms, 16 * ns_per_ms, 64 * ns_per_ms,
                                                               256 * ns_per_ms};
    std::array<TimeNs, count - 1> from_ns_ = usual_ns;
};

}  // namespace camrig::engine
