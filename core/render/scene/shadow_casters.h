#pragma once

#include <vector>

#include "core/render/scene/scene_view.h"
#include "core/render/shadow_plan.h"

/// What of a placed scene throws shadows, and what they fall on.
namespace camrig::render::scene {

/// Lamps, pictures of the sky and glass let light through.
inline bool casts_shadow(const PlacedSurface& surface) {
    const PreparedPrimitive& primitive = *surface.primitive;
    return primitive.is_lit && !primitive.is_blended && primitive.source->topology == world::Topology::triangles;
}

/// Boxes of what stands still and is lit.
inline std::vector<WorldBox> shadow_receivers(const PlacedScene& scene) {
    std::vector<WorldBox> boxes;
    for (const PlacedSurface& surface : scene.statics().all()) {
        if (surface.primitive->is_lit) boxes.push_back(world_box(surface.world_from_local, surface.bounds));
    }
    return boxes;
}

/// Boxes of what the pictures of backdrops show, beside what is in the scene.
inline std::vector<WorldBox> shadow_catchers(const PlacedScene& scene) {
    std::vector<WorldBox> boxes;
    scene.each_proxy([&](const PlacedSurface& surface) {
        if (surface.primitive->is_lit) boxes.push_back(world_box(surface.world_from_local, surface.bounds));
    });
    return boxes;
}

/// Boxes of what moves and casts, into `to`.
inline void find_moving_casters(const PlacedScene& scene, std::vector<WorldBox>& to) {
    to.clear();
    for (const PlacedSurface& surface : scene.movers().all()) {
        if (casts_shadow(surface)) to.push_back(world_box(surface.world_from_local, surface.bounds));
    }
}

/// With which level of detail a surface casts into a map.
inline int shadow_level(const PlacedSurface& surface, double max_error_m) {
    return coarsest_level(surface, [&](double error_m) { return error_m <= max_error_m; });
}

}  // namespace camrig::render::scene
