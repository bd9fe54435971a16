#pragma once

#include <filesystem>
#include <functional>

#include "core/base/result.h"
#include "core/world/scene.h"

/// Finds the light of a scene's still things before anything is drawn: `camrig bake`.
///
///     shapes -> charts (unwrap) -> rectangles of a map (rect_packing) -> places (light_map)
///            -> light at them, by rays (ray_scene, transport) -> BakedLight (core/world/baked) -> a file
namespace camrig::bake {

struct BakeOptions {
    double texels_per_m = 10.0;  ///< fewer where the map would be larger than max_side
    int max_side = 2048;
    int rays = 256;                ///< of a texel
    int bounces = 16;              ///< before the last, at most: fewer where they add nothing any more
    double probe_spacing_m = 1.0;  ///< wider where there would be more than max_probes
    int max_probes = 40000;
    std::size_t reflections = 12;  ///< reflection probes at most; fewer where less mirrors
    int threads = 1;
    /// What was found is kept there until all is, and taken from there; empty: it is not.
    std::filesystem::path checkpoint = {};
    /// What is done, of 1. False ends it all.
    std::function<bool(double)> progress = {};
};

/// The light of a scene that was loaded without one (SceneOptions::baked_light). Same bytes for the same scene and
/// options, with any number of threads. Errors: invalid_argument for a scene in which nothing that stands still is lit,
/// unavailable where `progress` ended it.
Result<world::BakedLight> bake(const world::SceneRef& scene, const BakeOptions& options);

}  // namespace camrig::bake
