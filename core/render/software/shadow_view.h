#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <glm/glm.hpp>

#include "core/render/shadow_plan.h"

/// Shadow maps as pictures look them up (shadow_lookup.h).
namespace camrig::render::software {

/// Around the texels of a map lie some that nothing is before, so that a filter needs no border of its own.
inline constexpr int shadow_pad = 8;
/// Texels along a side of a map with them.
constexpr int shadow_stride(int side) {
    return side + 2 * shadow_pad;
}
constexpr std::size_t shadow_texels_of_map(int side) {
    return static_cast<std::size_t>(shadow_stride(side)) * static_cast<std::size_t>(shadow_stride(side));
}
/// Movers are noted by squares of so many texels a side.
inline constexpr int shadow_tile = 16;
constexpr int shadow_tiles(int side) {
    return shadow_stride(side) / shadow_tile;
}
static_assert(shadow_stride(shadow_map_side) % shadow_tile == 0);
static_assert(shadow_stride(fine_shadow_map_side) % shadow_tile == 0);
/// Texels that the filter reads before and behind the corner that it begins at, along each side.
inline constexpr int shadow_filter_before = 2, shadow_filter_behind = 1;

/// Between what depths all texels are that a filter in a tile may read. Of what stands still.
struct ShadowBounds {
    float least, most;
};

/// A map of a light for one view; those of one light come after each other. Depth in it is reversed: what is nearer to
/// the light has more.
struct ShadowInView {
    std::size_t light = 0;       ///< into the scene's lights
    int side = shadow_map_side;  ///< texels, without the pad
    /// Of a point in the optical frame: column and row in texels with the pad, depth, and w that all three are divided
    /// by: the distance from a local light along the map's axis, else 1.
    std::array<glm::vec4, 4> rows{};
    std::array<glm::vec4, 3> planes{};         ///< plane_rows() of those
    float texel_m = 0.0f, texel_per_m = 0.0f;  ///< as of ShadowView
    const float* texels = nullptr;  ///< of what stands still; behind them come as many of that and of what moves
    /// By tile: 0, or where a mover may be in the way of a look-up that begins there, shadow_texels_of_map().
    const std::int32_t* movers = nullptr;
    const ShadowBounds* bounds = nullptr;  ///< by tile
};

}  // namespace camrig::render::software
