#pragma once

#include "core/world/baked/baked_light.h"
#include "core/world/model.h"

namespace camrig::bake {

inline constexpr int max_chart_side = 2048;

/// Cuts a triangle mesh into charts, pieces that are nearly flat, and lays them side by side. A chart is seen along its
/// normal, so lengths in it are right to a fifth. texels_per_unit: of the mesh's own unit; fewer where a chart would be
/// longer than max_chart_side or all would have no room. Every texel that a place of a chart is filtered from belongs
/// to this chart alone. A mesh that has no room at all is left whole: its size is 0x0.
world::BakedPrimitive unwrap(const world::Primitive& primitive, double texels_per_unit);

}  // namespace camrig::bake
