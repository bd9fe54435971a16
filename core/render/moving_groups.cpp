#include "core/render/moving_groups.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace camrig::render {
namespace {

/// More than so many are all together: each is compared with each.
constexpr std::size_t most_apart = 512;

/// 1, 2, 3, 4, 6, 8, 12, 16, 24, ..: which ways are about as far.
int step_of(double px) {
    int power = 1;
    while (2 * power < px && power < 1 << 20) power *= 2;
    if (px <= power) return power;
    return power > 1 && px <= 1.5 * power ? 3 * power / 2 : 2 * power;
}

/// For each way the first of those that it is together with.
std::vector<std::size_t> first_beside(const std::vector<MoverWay>& ways) {
    std::vector<std::size_t> first(ways.size(), 0);
    if (ways.size() > most_apart) return first;
    std::iota(first.begin(), first.end(), std::size_t{0});
    const auto root = [&](std::size_t i) {
        while (first[i] != i) i = first[i] = first[first[i]];
        return i;
    };
    for (std::size_t i = 0; i < ways.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            if (ways[i].rect.intersects(ways[k].rect)) {
                const std::size_t a = root(i), b = root(k);
                first[std::max(a, b)] = std::min(a, b);
            }
    for (std::size_t i = 0; i < ways.size(); ++i) first[i] = root(i);
    return first;
}

}  // namespace

std::vector<MovingGroup> moving_groups(const std::vector<MoverWay>& ways) {
    const std::vector<std::size_t> first = first_beside(ways);
    std::vector<double> px(ways.size(), 0.0);
    for (std::size_t i = 0; i < ways.size(); ++i) px[first[i]] = std::max(px[first[i]], ways[i].px);
    std::map<int, MovingGroup> by_step;
    for (std::size_t i = 0; i < ways.size(); ++i) {
        MovingGroup& group = by_step[step_of(px[first[i]])];
        group.movers.push_back(ways[i].id);
        group.moved_px = std::max(group.moved_px, ways[i].px);
    }
    std::vector<MovingGroup> groups;
    for (auto& [step, group] : by_step) {
        std::ranges::sort(group.movers);
        groups.push_back(std::move(group));
    }
    return groups;
}

}  // namespace camrig::render
