#pragma once

#include <array>
#include <vector>

#include "core/base/time.h"

namespace camrig::engine {

/// Which cameras cost alike: classes of drawing time, whose bounds are about a factor of 4 apart. Each bound lies in
/// the middle of the widest gap that the cameras' costs leave there: no bound divides cameras of like cost, whose costs
/// vary a little. Pure arithmetic: no clock, no threads.
class CostClasses {
public:
    static constexpr int count = 5;

    /// What all cost at present, in any order; the order is not kept.
    void divide(std::vector<TimeNs>& costs_ns);
    /// 0 is the cheapest.
    int of(TimeNs cost_ns) const;

private:
    /// The least cost of each class but the first, where no camera costs anything like it.
    static constexpr std::array<TimeNs, count - 1> usual_ns = {4 * ns_per_ms, 16 * ns_per_ms, 64 * ns_per_ms,
                                                               256 * ns_per_ms};
    std::array<TimeNs, count - 1> from_ns_ = usual_ns;
};

}  // namespace camrig::engine
