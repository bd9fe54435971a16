#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/result.h"
#include "core/world/baked/baked_light.h"
#include "core/world/scene.h"

/// The text of a file of light: all but its large parts, and how long these are.
namespace camrig::world {

inline constexpr int max_light_map_side = 8192;
inline constexpr std::size_t max_light_layers = 64;
inline constexpr std::int64_t max_light_texels = std::int64_t{1} << 27;  ///< of all layers; 512 MiB of memory
inline constexpr std::size_t max_light_probes = std::size_t{1} << 21;    ///< of all layers; 216 MiB of memory

nlohmann::json baked_light_header(const BakedLight& light);

struct BakedLightHeader {
    BakedLight light;  ///< without cuts, texels and probes
    struct Counts {
        std::size_t vertices = 0, indices = 0;
    };
    std::vector<Counts> cuts;  ///< of the primitives of all models
};
/// Errors: invalid_argument for a text that is none, or not of this scene, and `unsupported` where the scene has
/// changed since.
Result<BakedLightHeader> read_baked_light_header(const nlohmann::json& text, const Scene& scene);

/// Mesh after mesh.
std::vector<const Primitive*> primitives_of(const Model& model);

}  // namespace camrig::world
