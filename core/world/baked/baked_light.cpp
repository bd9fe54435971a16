#include "core/world/baked/baked_light.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <type_traits>

#include "core/world/daylit.h"
#include "core/world/scene.h"

namespace camrig::world {
namespace {

/// FNV-1a over words of 64 bits. Against mistakes, not against attacks: a file that lies about it is only wrong.
class KeyMaker {
public:
    template <typename T>
        requires std::is_arithmetic_v<T> || std::is_enum_v<T>
    void add(T value) {
        if constexpr (std::is_floating_point_v<T>) {
            mix(std::bit_cast<std::uint64_t>(static_cast<double>(value)));
        } else {
            mix(static_cast<std::uint64_t>(value));
        }
    }
    template <glm::length_t n, typename T>
    void add(const glm::vec<n, T>& value) {
        for (glm::length_t i = 0; i < n; ++i) add(value[i]);
    }
    void add(const glm::dquat& q) { add(glm::dvec4(q.x, q.y, q.z, q.w)); }
    void add(const std::string& text) { add_bytes(text.data(), text.size()); }
    /// Values without padding.
    template <typename T>
    void add(const std::vector<T>& values) {
        add_bytes(values.data(), values.size() * sizeof(T));
    }
    std::uint64_t key() const { return key_; }

private:
    void add_bytes(const void* from, std::size_t size) {
        mix(size);
        const auto* at = static_cast<const std::byte*>(from);
        for (; size > 0; at += 8) {
            std::uint64_t word = 0;
            const std::size_t part = std::min<std::size_t>(size, 8);
            std::memcpy(&word, at, part);
            mix(word);
            size -= part;
        }
    }
    void mix(std::uint64_t word) {
        key_ = (key_ ^ word) * 0x100000001B3u;
        key_ ^= key_ >> 29;
    }

    std::uint64_t key_ = 0xCBF29CE484222325u;
};

void add(KeyMaker& key, const TextureRef& ref) {
    key.add(ref.texture);
    key.add(ref.texcoord);
    key.add(ref.offset);
    key.add(ref.scale);
    key.add(ref.rotation);
}

void add(KeyMaker& key, const Material& material) {
    key.add(material.base_color);
    add(key, material.base_color_texture);
    key.add(material.metallic);
    key.add(material.roughness);
    add(key, material.metallic_roughness_texture);
    key.add(material.emissive);
    add(key, material.emissive_texture);
    key.add(material.alpha_mode);
    key.add(material.alpha_cutoff);
    key.add(material.double_sided);
    key.add(material.unlit);
    key.add(material.transmission);
    key.add(material.tint);
}

void add(KeyMaker& key, const Model& model) {
    for (const Mesh& mesh : model.meshes) {
        for (const Primitive& primitive : mesh.primitives) {
            key.add(primitive.material);
            key.add(primitive.positions);
            key.add(primitive.normals);
            for (const auto& set : primitive.texcoords) key.add(set);
            key.add(primitive.colors);
            key.add(primitive.indices);
        }
    }
    for (const Node& node : model.nodes) {
        key.add(node.parent);
        key.add(node.local.translation);
        key.add(node.local.rotation);
        key.add(node.local.scale);
        for (glm::length_t i = 0; i < 4; ++i) key.add(node.matrix[i]);
        key.add(node.mesh);
        key.add(node.skin);
    }
    for (const Material& material : model.materials) add(key, material);
    for (const Texture& texture : model.textures) {
        key.add(texture.image);
        key.add(texture.sampler.wrap_s);
        key.add(texture.sampler.wrap_t);
    }
    for (const Image& image : model.images) {
        key.add(image.size.width);
        key.add(image.rgba);
    }
}

/// A list of values by which vertices of the file are taken.
template <typename T>
void take(std::vector<T>& values, const std::vector<std::uint32_t>& which) {
    if (values.empty()) return;
    std::vector<T> made;
    made.reserve(which.size());
    for (const std::uint32_t index : which) made.push_back(values[index]);
    values = std::move(made);
}

}  // namespace

void LightProbe::add(const glm::vec3& light, const glm::vec3& towards) {
    // A_l / A_0 Y_lm(towards) Y_lm(n) / Y_00^2 with A = pi, 2 pi / 3, pi / 4, but for the coordinates of both.
    constexpr float first = 2.0f;
    constexpr std::array<float, product_count> second{15.0f / 4.0f, 15.0f / 4.0f, 15.0f / 4.0f, 15.0f / 16.0f,
                                                      5.0f / 16.0f};
    mean += light;
    for (glm::length_t i = 0; i < 3; ++i) along[i] += light * (first * towards[i]);
    const auto of = products_of(towards);
    for (std::size_t i = 0; i < product_count; ++i) products[i] += light * (second[i] * of[i]);
}

LightProbe& LightProbe::operator+=(const LightProbe& other) {
    mean += other.mean;
    along += other.along;
    for (std::size_t i = 0; i < product_count; ++i) products[i] += other.products[i];
    return *this;
}

LightProbe LightProbe::scaled(const glm::vec3& by) const {
    LightProbe made{mean * by, along, products};
    for (glm::length_t i = 0; i < 3; ++i) made.along[i] *= by;
    for (glm::vec3& product : made.products) product *= by;
    return made;
}

std::uint64_t light_key(const Scene& scene) {
    KeyMaker key;
    key.add(3);  // the way of baking
    std::vector<const Model*> models;
    for (const ObjectSpec& object : scene.objects) {
        if (!object.clip.empty() || object.attach) continue;
        // Light comes from there, whatever it looks like.
        if (scene.models.at(object.model).model->sky_radius_m > 0.0) continue;
        key.add(object.name);
        key.add(object.model);
        key.add(object.position);
        key.add(object.orientation);
        key.add(object.scale);
        const Model* const model = scene.models.at(object.model).model.get();
        if (std::ranges::find(models, model) != models.end()) continue;
        models.push_back(model);
        add(key, *model);
    }
    for (const Light& light : scene.lights) {
        key.add(light.group);
        key.add(light.type);
        key.add(light.position);
        // The sun moves on; what was reflected of it is taken for what is.
        if (light.name != sun_name) key.add(light.direction);
        key.add(light.range);
        key.add(light.inner_cone_rad);
        key.add(light.outer_cone_rad);
    }
    return key.key();
}

std::shared_ptr<const Model> cut_model(const Model& model, const BakedModel& by) {
    auto made = std::make_shared<Model>(model);
    std::size_t number = 0;
    for (Mesh& mesh : made->meshes) {
        for (Primitive& primitive : mesh.primitives) {
            const BakedPrimitive& cut = by.primitives[number++];
            if (cut.size.width == 0) continue;
            take(primitive.positions, cut.vertices);
            take(primitive.normals, cut.vertices);
            take(primitive.tangents, cut.vertices);
            for (auto& set : primitive.texcoords) take(set, cut.vertices);
            take(primitive.colors, cut.vertices);
            primitive.indices = cut.indices;
            primitive.light_coordinates = cut.coordinates;
        }
    }
    return made;
}

void use_baked_light(Scene& scene, BakedLightRef light) {
    for (const BakedModel& model : light->models) {
        ModelRef& of = scene.models.at(model.name).model;
        of = cut_model(*of, model);
    }
    scene.baked_light = std::move(light);
}

}  // namespace camrig::world
