#include "core/render/software/software_model.h"

#include <algorithm>
#include <cmath>

namespace camrig {
namespace {

const Material& default_material() {
    static const Material material;
    return material;
}

SampledTexture use_of(SoftwareModel& model, const Primitive& primitive, const TextureRef& ref, bool is_color) {
    SampledTexture use;
    if (ref.texture < 0) return use;
    const std::vector<glm::vec2>& coordinates = primitive.texcoords[ref.texcoord];
    if (coordinates.empty()) return use;
    const Texture& texture = model.source->textures[static_cast<std::size_t>(ref.texture)];
    std::unique_ptr<SoftwareImage>& image = model.images[{texture.image, is_color}];
    if (image == nullptr) {
        image = std::make_unique<SoftwareImage>(
            make_software_image(model.source->images[static_cast<std::size_t>(texture.image)], is_color));
    }
    use.image = image.get();
    use.sampler = texture.sampler;
    // KHR_texture_transform: translation * rotation * scale; counter-clockwise with v pointing down.
    const float c = std::cos(ref.rotation), s = std::sin(ref.rotation);
    use.coordinates.reserve(coordinates.size());
    for (const glm::vec2& at : coordinates) {
        const glm::vec2 scaled = at * ref.scale;
        use.coordinates.push_back(ref.offset + glm::vec2(c * scaled.x + s * scaled.y, c * scaled.y - s * scaled.x));
    }
    return use;
}

SoftwareLevel level_of(const std::vector<std::uint32_t>& indices, float error) {
    SoftwareLevel level{.triangles = {}, .vertices = indices, .error = error};
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        for (std::size_t c = 0; c < 3; ++c) level.triangles[c].push_back(indices[i + c]);
    }
    std::ranges::sort(level.vertices);
    const auto repeated = std::ranges::unique(level.vertices);
    level.vertices.erase(repeated.begin(), repeated.end());
    return level;
}

}  // namespace

std::unique_ptr<SoftwareModel> make_software_model(const ModelRef& source) {
    auto model = std::make_unique<SoftwareModel>();
    model->source = source;
    for (const Mesh& mesh : source->meshes) {
        auto& primitives = model->meshes.emplace_back();
        for (const Primitive& primitive : mesh.primitives) {
            SoftwarePrimitive made;
            made.source = &primitive;
            made.material = primitive.material < 0 ? &default_material()
                                                   : &source->materials[static_cast<std::size_t>(primitive.material)];
            made.is_lit = !made.material->unlit && !primitive.normals.empty();
            made.base_color = use_of(*model, primitive, made.material->base_color_texture, true);
            if (made.is_lit) {
                made.emissive = use_of(*model, primitive, made.material->emissive_texture, true);
                made.occlusion = use_of(*model, primitive, made.material->occlusion_texture, false);
            }
            made.levels.push_back(level_of(primitive.indices, 0.0f));
            for (const DetailLevel& level : make_detail_levels(primitive))
                made.levels.push_back(level_of(level.indices, level.error));
            made.joint_boxes = joint_boxes_of(primitive);
            model->has_only_triangles &= primitive.topology == Topology::triangles;
            primitives.push_back(std::move(made));
        }
    }
    model->surfaces = draw_order(*source);
    return model;
}

}  // namespace camrig
