#pragma once

#include <glm/glm.hpp>

#include "core/render/software/lanes.h"

namespace camrig::render::software {

/// Points of a mesh in the space that `m` takes them to, for a group of lanes; at: their numbers.
struct PointLanes {
    Doubles x, y, z;
};
template <typename Isa>
CAMRIG_LANES PointLanes transformed(const glm::dmat4& m, const glm::vec3* positions, IntLanes at) {
    static_assert(sizeof(glm::vec3) == 12);
    const float* const from = &positions->x;
    const Doubles x = widened(gathered<Isa>(from, at * 3));
    const Doubles y = widened(gathered<Isa>(from + 1, at * 3));
    const Doubles z = widened(gathered<Isa>(from + 2, at * 3));
    const auto row = [&](int r)
                         __attribute__((always_inline)) { return x * m[0][r] + y * m[1][r] + z * m[2][r] + m[3][r]; };
    return {row(0), row(1), row(2)};
}

}  // namespace camrig::render::software
