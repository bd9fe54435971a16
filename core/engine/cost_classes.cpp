#include "core/engine/cost_classes.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace camrig::engine {
namespace {

/// A bound lies within this factor of where it usually is, so that two of them never meet.
constexpr double most_moved = 1.6;
/// A bound stays in its gap until another is wider by this factor: costs vary.
constexpr double margin = 1.25;
/// What differs by less than this factor is of like cost: no gap to stay in.
constexpr double alike = 1.4;

TimeNs times(TimeNs value_ns, double factor) {
    return static_cast<TimeNs>(static_cast<double>(value_ns) * factor);
}

/// The middle, in proportion, of the widest gap that least, the sorted costs and most leave between them.
TimeNs middle_of_gap(TimeNs least, std::span<const TimeNs> costs, TimeNs most, TimeNs present) {
    TimeNs below = least, found = present;
    double widest = 0.0;
    const auto look_at = [&](TimeNs above) {
        const double ratio = static_cast<double>(above) / static_cast<double>(below);
        const bool stays = below < present && present <= above && ratio >= alike;
        if (const double width = stays ? ratio * margin : ratio; width > widest) {
            widest = width;
            found = times(below, std::sqrt(ratio));
        }
        below = above;
    };
    for (const TimeNs cost : costs) look_at(cost);
    look_at(most);
    return found;
}

}  // namespace

void CostClasses::divide(std::vector<TimeNs>& costs_ns) {
    std::ranges::sort(costs_ns);
    for (std::size_t i = 0; i < from_ns_.size(); ++i) {
        const TimeNs least = times(usual_ns[i], 1.0 / most_moved), most = times(usual_ns[i], most_moved);
        const auto first = std::ranges::lower_bound(costs_ns, least), end = std::ranges::upper_bound(costs_ns, most);
        from_ns_[i] = first == end ? usual_ns[i] : middle_of_gap(least, {first, end}, most, from_ns_[i]);
    }
}

int CostClasses::of(TimeNs cost_ns) const {
    return static_cast<int>(std::ranges::upper_bound(from_ns_, cost_ns) - from_ns_.begin());
}

}  // namespace camrig::engine
