#pragma once

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "core/render/scene/prepared_model.h"
#include "core/render/shared_models.h"
#include "core/render/software/mesh_neighbors.h"
#include "core/render/software/texture.h"

namespace camrig {

/// A texture as a material uses it, with the coordinates of each vertex (KHR_texture_transform applied).
struct SampledTexture {
    const SoftwareImage* image = nullptr;  ///< null: none
    Sampler sampler;
    std::vector<glm::vec2> coordinates;
};
enum TextureSlot { base_color_slot, emissive_slot, occlusion_slot, texture_slot_count };

struct SoftwarePrimitive;

/// Of the full mesh of a primitive and of each coarser one. Made when a picture first needs them; from any thread.
class NeighborsOfLevels {
public:
    const MeshNeighbors& of(const SoftwarePrimitive& primitive, const PreparedPrimitive& prepared, int level);

private:
    std::once_flag once_;
    std::vector<MeshNeighbors> levels_;
};

struct SoftwarePrimitive {
    MeshLevel full;
    std::unique_ptr<NeighborsOfLevels> neighbors = std::make_unique<NeighborsOfLevels>();
    std::array<SampledTexture, texture_slot_count> textures;
};

/// A Model as the software rasteriser draws it: the model's own arrays, textures in linear light.
struct SoftwareModel {
    std::vector<SoftwarePrimitive> primitives;                              ///< as of PreparedModel
    std::map<std::pair<int, bool>, std::unique_ptr<SoftwareImage>> images;  ///< by image and whether it is colour
};
SoftwareModel make_software_model(const Model& model, const PreparedModel& prepared);

}  // namespace camrig
