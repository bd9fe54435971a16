#pragma once

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "core/render/scene/prepared_model.h"
#include "core/render/shared_caches.h"
#include "core/render/software/mesh_neighbors.h"
#include "core/render/software/texture.h"

namespace camrig::render::software {

/// A texture as a material uses it, with the coordinates of each vertex (KHR_texture_transform applied).
struct SampledTexture {
    const SoftwareImage* image = nullptr;  ///< null: none
    world::Sampler sampler;
    std::vector<glm::vec2> coordinates;
};
enum TextureSlot {
    base_color_slot,
    emissive_slot,
    occlusion_slot,
    normal_slot,  ///< this and what follows: only of quality beautiful
    metallic_roughness_slot,
    light_slot,  ///< the map of baked light (BakedPicture)
    texture_slot_count
};

/// The images of a model in linear light or as plain data, made when a primitive first uses them; from any thread.
class SoftwareImages {
public:
    const SoftwareImage& of(const world::Model& model, int image, bool is_color);

private:
    std::mutex mutex_;
    std::map<std::pair<int, bool>, std::unique_ptr<SoftwareImage>> images_;
};

struct SoftwarePrimitive;

/// Of the full mesh of a primitive and of each coarser one. Made when a picture first needs them; from any thread.
class NeighborsOfLevels {
public:
    const MeshNeighbors& of(const SoftwarePrimitive& primitive, const scene::PreparedPrimitive& prepared, int level);

private:
    std::once_flag once_;
    std::vector<MeshNeighbors> levels_;
};

/// The textures that only quality beautiful samples, from normal_slot on. Made when a picture first needs them; from
/// any thread.
class MaterialTextures {
public:
    MaterialTextures(const world::Model& model, std::shared_ptr<SoftwareImages> images)
        : model_(model), images_(std::move(images)) {}
    const SampledTexture& of(const scene::PreparedPrimitive& prepared, TextureSlot slot);

private:
    const world::Model& model_;
    std::shared_ptr<SoftwareImages> images_;
    std::once_flag once_;
    std::array<SampledTexture, light_slot - normal_slot> made_;
};

struct SoftwarePrimitive {
    scene::MeshLevel full;
    std::unique_ptr<NeighborsOfLevels> neighbors = std::make_unique<NeighborsOfLevels>();
    std::array<SampledTexture, normal_slot> textures;
    std::unique_ptr<MaterialTextures> of_material;
};

/// A Model as the software rasteriser draws it: the model's own arrays, textures in linear light.
struct SoftwareModel {
    std::vector<SoftwarePrimitive> primitives;  ///< as of PreparedModel
    std::shared_ptr<SoftwareImages> images = std::make_shared<SoftwareImages>();
};
SoftwareModel make_software_model(const world::Model& model, const scene::PreparedModel& prepared);

}  // namespace camrig::render::software
