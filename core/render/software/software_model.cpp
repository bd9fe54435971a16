#include "core/render/software/software_model.h"

#include "core/render/scene/texture_transform.h"

namespace camrig::render::software {
namespace {

SampledTexture use_of(SoftwareImages& images, const world::Model& model, const world::Primitive& primitive,
                      const world::TextureRef& ref, bool is_color) {
    SampledTexture use;
    if (ref.texture < 0) return use;
    const std::vector<glm::vec2>& coordinates = primitive.texcoords[ref.texcoord];
    if (coordinates.empty()) return use;
    const world::Texture& texture = model.textures[static_cast<std::size_t>(ref.texture)];
    use.image = &images.of(model, texture.image, is_color);
    use.sampler = texture.sampler;
    const scene::TextureTransform transform = scene::transform_of(ref);
    use.coordinates.reserve(coordinates.size());
    for (const glm::vec2& at : coordinates) use.coordinates.push_back(transform(at));
    return use;
}

}  // namespace

const SoftwareImage& SoftwareImages::of(const world::Model& model, int image, bool is_color) {
    const std::lock_guard lock(mutex_);
    std::unique_ptr<SoftwareImage>& made = images_[{image, is_color}];
    if (made == nullptr)
        made = std::make_unique<SoftwareImage>(
            make_software_image(model.images[static_cast<std::size_t>(image)], is_color));
    return *made;
}

const SampledTexture& MaterialTextures::of(const scene::PreparedPrimitive& prepared, TextureSlot slot) {
    std::call_once(once_, [&] {
        const world::Material& material = *prepared.material;
        const auto use = [&](TextureSlot of, const world::TextureRef& ref) {
            made_[of - normal_slot] = use_of(*images_, model_, *prepared.source, ref, false);
        };
        use(normal_slot, material.normal_texture);
        use(metallic_roughness_slot, material.metallic_roughness_texture);
    });
    return made_[slot - normal_slot];
}

const MeshNeighbors& NeighborsOfLevels::of(const SoftwarePrimitive& primitive, const scene::PreparedPrimitive& prepared,
                                           int level) {
    std::call_once(once_, [&] {
        // All or none of them: without memory it is called again.
        std::vector<MeshNeighbors> levels;
        levels.push_back(neighbors_of(primitive.full.triangles, *prepared.source));
        for (const scene::MeshLevel& coarser : prepared.coarser)
            levels.push_back(neighbors_of(coarser.triangles, *prepared.source));
        levels_ = std::move(levels);
    });
    return levels_[static_cast<std::size_t>(level)];
}

SoftwareModel make_software_model(const world::Model& model, const scene::PreparedModel& prepared) {
    SoftwareModel made;
    for (const scene::PreparedPrimitive& primitive : prepared.primitives) {
        SoftwarePrimitive& entry = made.primitives.emplace_back();
        entry.full = scene::mesh_level(primitive.source->indices, 0.0f);
        const auto use = [&](TextureSlot slot, const world::TextureRef& ref, bool is_color) {
            entry.textures[slot] = use_of(*made.images, model, *primitive.source, ref, is_color);
        };
        use(base_color_slot, primitive.material->base_color_texture, true);
        if (!primitive.is_lit) continue;
        use(emissive_slot, primitive.material->emissive_texture, true);
        use(occlusion_slot, primitive.material->occlusion_texture, false);
        entry.of_material = std::make_unique<MaterialTextures>(model, made.images);
    }
    return made;
}

}  // namespace camrig::render::software
