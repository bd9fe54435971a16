#pragma once

#include <functional>
#include <vector>

#include "core/bake/checkpoint.h"
#include "core/bake/light_map.h"
#include "core/world/scene.h"

/// How light gets from its sources to the places of a map, over surfaces that scatter it to all sides.
namespace camrig::bake {

/// Which source a layer is of.
struct Source {
    world::LightSource kind = world::LightSource::sky;
    std::vector<std::size_t> lamps{};  ///< of LightSource::lamp
};

struct TransportOptions {
    int rays = 512;                    ///< of a texel, for what is drawn
    int coarse_rays = 64;              ///< of a texel, for each bounce before
    int bounces = 16;                  ///< beside the last, at most: fewer where they add nothing any more
    int probe_rays = 1024;             ///< of a probe
    std::size_t most_reflections = 0;  ///< reflection probes
    int threads = 1;
    Checkpoint* checkpoint = nullptr;  ///< null: nothing is kept
    /// What is done, of 1; from the thread that asked. False ends it all.
    std::function<bool(double)> progress = {};
};

/// By layer, then by texel of the map: light as LightLayer has it.
struct Transport {
    std::vector<std::vector<glm::vec3>> texels;
    std::vector<std::vector<world::LightProbe>> probes;
    std::vector<std::uint8_t> is_open;  ///< by probe
    world::ReflectionProbes reflection_probes;
    std::vector<std::vector<glm::vec3>> reflections;  ///< by layer, as LightLayer has them
    bool is_whole = false;                            ///< it was not ended
};

/// Each pass gathers at every texel what its rays meet: the sky, what glows, and other texels with what the pass before
/// left there (Goral et al., Modeling the interaction of light between diffuse surfaces, 1984, solved by rays). The
/// same numbers with any number of threads.
Transport find_transport(const RayScene& scene, const LightMap& map, std::span<const Source> sources,
                         const world::Scene& of, const world::ProbeGrid& grid, const TransportOptions& options);

}  // namespace camrig::bake
