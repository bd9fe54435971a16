#pragma once

#include <array>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/base/result.h"

namespace camrig::world {

/// The triangles of a polygon in either order of its corners, counter-clockwise where y is up, as indices into it.
/// Error invalid_argument: fewer than 3 corners, no area, or it crosses itself. Takes time with the square of the
/// corners, at worst the cube.
Result<std::vector<std::array<std::uint32_t, 3>>> triangles_of(std::span<const glm::dvec2> polygon);

}  // namespace camrig::world
