#pragma once

#include <algorithm>
#include <array>
#include <bit>

#include "core/render/scene/probe_cells.h"
#include "core/render/software/lanes.h"
#include "core/world/baked/reflection_probes.h"

/// Which reflection probes light places.
namespace camrig::render::software {

/// The two nearest probes of places, and how much of the second counts.
struct NearestProbes {
    IntLanes first, second;
    Lanes share;
};
/// place: from ProbeCells::first(). Mirrors have those that have an image for them.
template <typename Isa>
CAMRIG_LANES NearestProbes nearest_probes(const scene::ProbeCells& cells, const Lanes3& place, IntLanes is_mirror) {
    const auto [xs, ys, zs] = std::array{cells.places()[0].data(), cells.places()[1].data(), cells.places()[2].data()};
    Lanes first2 = lanes(1e30f), second2 = lanes(1e30f);
    IntLanes first{}, second{};
    const auto weigh = [&](std::int32_t i, IntLanes who) __attribute__((always_inline)) {
        const Lanes3 away{place.x - xs[i], place.y - ys[i], place.z - zs[i]};
        const Lanes distance2 = dot(away, away);
        // One may be weighed twice.
        const IntLanes is_first = who & (distance2 < first2), is_second = who & (distance2 < second2) & (first != i);
        second = is_first ? first : is_second ? IntLanes{} + i : second;
        second2 = is_first ? first2 : is_second ? distance2 : second2;
        first = is_first ? IntLanes{} + i : first;
        first2 = is_first ? distance2 : first2;
    };
    if (Isa::bits(is_mirror) != 0) {
        const auto count = static_cast<std::int32_t>(std::min(cells.size(), world::most_mirror_probes));
        for (std::int32_t i = 0; i < count; ++i) weigh(i, is_mirror);
    }
    const glm::ivec3& count = cells.count();
    IntLanes is_inside{};
    is_inside = ~is_inside;
    const auto cell_along = [&](Lanes at, std::int32_t most) __attribute__((always_inline)) {
        const Lanes cell = floor(at * cells.cells_per_m());
        is_inside &= (cell >= 0.0f) & (cell < static_cast<float>(most));
        return truncated(min(max(cell, Lanes{}), lanes(static_cast<float>(most - 1))));
    };
    const IntLanes x = cell_along(place.x, count.x), y = cell_along(place.y, count.y), z = cell_along(place.z, count.z);
    const IntLanes cell = is_inside ? (z * count.y + y) * count.x + x : IntLanes{} + cells.beyond();
    for (unsigned left = Isa::bits(~is_mirror); left != 0;) {
        const std::int32_t one = cell[std::countr_zero(left)];
        const IntLanes is_there = cell == one;
        left &= ~Isa::bits(is_there);
        for (const std::uint16_t i : cells.of(one)) weigh(i, is_there & ~is_mirror);
    }
    // Half of each where they are equally far, and no more of the second where it is a sixth further away.
    constexpr float alone = 0.7225f;
    const Lanes nearly = clamp01((first2 / second2 - alone) * (1.0f / (1.0f - alone)));
    return {first, second, nearly * nearly * (1.5f - nearly)};
}

}  // namespace camrig::render::software
