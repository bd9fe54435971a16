#pragma once

#include <array>
#include <map>
#include <memory>
#include <vector>

#include "core/render/detail_levels.h"
#include "core/render/draw_order.h"
#include "core/render/placement.h"
#include "core/render/software/screen_triangles.h"
#include "core/render/software/texture.h"

namespace camrig {

/// A texture as a material uses it, with the coordinates of each vertex (KHR_texture_transform applied).
struct SampledTexture {
    const SoftwareImage* image = nullptr;  ///< null: none
    Sampler sampler;
    std::vector<glm::vec2> coordinates;
};

/// The triangles of a level of detail and the vertices that they use, rising.
struct SoftwareLevel {
    TriangleCorners triangles;
    std::vector<std::uint32_t> vertices;
    float error = 0.0f;  ///< as of DetailLevel; 0: the full mesh
};

/// One draw of a mesh, with its material.
struct SoftwarePrimitive {
    const Primitive* source = nullptr;
    const Material* material = nullptr;
    SampledTexture base_color;
    SampledTexture emissive;
    SampledTexture occlusion;
    bool is_lit = false;
    std::vector<SoftwareLevel> levels;  ///< the full mesh, then coarser and coarser ones
    std::vector<JointBox> joint_boxes;
};

/// A Model as the software rasteriser draws it: the model's own arrays, textures in linear light, levels of detail.
struct SoftwareModel {
    ModelRef source;  ///< keeps all that is pointed at alive
    std::vector<std::vector<SoftwarePrimitive>> meshes;
    std::vector<Surface> surfaces;                                          ///< as they are drawn
    std::map<std::pair<int, bool>, std::unique_ptr<SoftwareImage>> images;  ///< by image and whether it is colour
    bool has_only_triangles = true;
};

std::unique_ptr<SoftwareModel> make_software_model(const ModelRef& model);

}  // namespace camrig
