#include "core/world/gltf/material_reader.h"

#include <algorithm>
#include <cmath>

#include "core/world/gltf/image_decode.h"
#include "core/world/gltf/resources.h"

namespace camrig::world::gltf {
namespace {

float factor(double value, double high, std::string_view place) {
    require(std::isfinite(value), place, "is not finite");
    return static_cast<float>(std::clamp(value, 0.0, high));
}

/// KHR_texture_transform, read from the parsed extension object.
void apply_transform(const tinygltf::ExtensionMap& extensions, TextureRef& ref, const std::string& place) {
    const auto found = extensions.find("KHR_texture_transform");
    if (found == extensions.end() || !found->second.IsObject()) return;
    const tinygltf::Value& value = found->second;
    const std::string at = place + ".extensions.KHR_texture_transform";
    const auto number = [&](const tinygltf::Value& n, const char* key) {
        require(n.IsNumber() && std::abs(n.GetNumberAsDouble()) <= 1e6, at + "." + key, "expected a number within 1e6");
        return static_cast<float>(n.GetNumberAsDouble());
    };
    const auto pair = [&](const char* key, glm::vec2& out) {
        if (!value.Has(key)) return;
        const tinygltf::Value& list = value.Get(key);
        require(list.IsArray() && list.ArrayLen() == 2, at + "." + key, "expected an array of 2 numbers");
        out = {number(list.Get(0), key), number(list.Get(1), key)};
    };
    pair("offset", ref.offset);
    pair("scale", ref.scale);
    if (value.Has("rotation")) ref.rotation = number(value.Get("rotation"), "rotation");
    if (value.Has("texCoord") && value.Get("texCoord").IsInt()) ref.texcoord = value.Get("texCoord").GetNumberAsInt();
}

/// KHR_materials_emissive_strength: how many times brighter than its factor and texture.
float emissive_strength(const tinygltf::ExtensionMap& extensions, const std::string& place) {
    const auto found = extensions.find("KHR_materials_emissive_strength");
    if (found == extensions.end() || !found->second.Has("emissiveStrength")) return 1.0f;
    const tinygltf::Value& value = found->second.Get("emissiveStrength");
    const std::string at = place + ".extensions.KHR_materials_emissive_strength.emissiveStrength";
    require(value.IsNumber(), at, "expected a number");
    return factor(value.GetNumberAsDouble(), 1e6, at);
}

/// KHR_materials_transmission, by its factor: light of a share of it goes through, in the material's color, and is
/// not scattered. What is blended over is dimmed by the mean of the color; `tint` is how each channel differs.
void let_through(const tinygltf::ExtensionMap& extensions, const std::string& place, Material& to) {
    const auto found = extensions.find("KHR_materials_transmission");
    if (found == extensions.end() || !found->second.Has("transmissionFactor")) return;
    const tinygltf::Value& value = found->second.Get("transmissionFactor");
    const std::string at = place + ".extensions.KHR_materials_transmission.transmissionFactor";
    require(value.IsNumber(), at, "expected a number");
    const float transmission = factor(value.GetNumberAsDouble(), 1.0, at);
    // What is cut out by alpha stays so: it is there or not.
    if (transmission == 0.0f || to.alpha_mode == AlphaMode::mask) return;
    to.transmission = transmission;
    if (to.alpha_mode == AlphaMode::opaque) to.base_color.a = 1.0f;
    const glm::vec3 color(to.base_color);
    const float kept = 1.0f - to.transmission * (color.r + color.g + color.b) / 3.0f;
    const glm::vec3 through = 1.0f - to.base_color.a * (1.0f - to.transmission * color);
    to.tint = through / std::max(1.0f - to.base_color.a * kept, 1e-3f);
    to.base_color = glm::vec4(color * ((1.0f - to.transmission) / std::max(kept, 1e-3f)), to.base_color.a * kept);
    to.alpha_mode = AlphaMode::blend;
}

/// A texture without `source` is legal (glTF 2.0, 3.8.2): an extension gives its picture. Without that extension there
/// is none.
bool has_picture(const tinygltf::Texture& texture) {
    return texture.source >= 0;
}

template <typename Info>
TextureRef texture_ref(const Document& document, const Info& info, const std::string& place) {
    TextureRef ref{.texture = info.index, .texcoord = info.texCoord};
    if (info.index < 0) return ref;
    require(info.index < std::ssize(document.gltf.textures), place + ".index",
            "texture " + std::to_string(info.index) + " of " + std::to_string(document.gltf.textures.size()));
    if (!has_picture(document.gltf.textures[static_cast<std::size_t>(info.index)])) return {};
    apply_transform(info.extensions, ref, place);
    if (ref.texcoord < 0 || ref.texcoord > 1)
        fail(place + ".texCoord", "texture coordinate sets 0 and 1 are read", ErrorKind::unsupported);
    return ref;
}

AlphaMode alpha_mode(const std::string& name, const std::string& place) {
    if (name == "OPAQUE") return AlphaMode::opaque;
    if (name == "MASK") return AlphaMode::mask;
    if (name == "BLEND") return AlphaMode::blend;
    fail(place + ".alphaMode", "'" + name.substr(0, 40) + "' is none of OPAQUE, MASK, BLEND");
}

/// extras.camrig_variants (docs/scene-format.md, variants of a model). Strict: it is our own.
MaterialVariants read_variants(const nlohmann::json& extras, const std::string& place) {
    MaterialVariants to;
    require(extras.is_object(), place, "expected an object");
    const auto number = [](const nlohmann::json& value, const std::string& at) {
        require(value.is_number() && value.get<double>() >= 0.0 && value.get<double>() <= 1.0, at,
                "expected a number from 0 to 1");
        return value.get<double>();
    };
    const auto text = [](const nlohmann::json& value, const std::string& at) {
        require(value.is_string(), at, "expected a string");
        return value.get_ref<const std::string&>().substr(0, max_name_bytes);
    };
    for (const auto& [key, value] : extras.items()) {
        const std::string at = place + "." + key;
        if (key == "dye") {
            to.dye = text(value, at);
        } else if (key == "choice") {
            to.choice = text(value, at);
        } else if (key == "from") {
            to.from = number(value, at);
        } else if (key == "to") {
            to.to = number(value, at);
        } else if (key == "shown") {
            require(value.is_boolean(), at, "expected true or false");
            to.is_shown = value.get<bool>();
        } else if (key == "colors") {
            require(value.is_array() && !value.empty() && value.size() <= max_variant_colors, at,
                    "expected 1 to " + std::to_string(max_variant_colors) + " colors");
            for (const auto& color : value) {
                require(color.is_array() && color.size() == 3, at, "expected colors [r, g, b]");
                glm::vec3& made = to.colors.emplace_back();
                for (glm::length_t i = 0; i < 3; ++i)
                    made[i] = static_cast<float>(number(color[static_cast<std::size_t>(i)], at));
            }
        } else {
            fail(at, "there are choice, colors, dye, from, shown and to");
        }
    }
    return to;
}

Material read_material(const Document& document, const tinygltf::Material& from, const std::string& place) {
    Material to;
    to.name = from.name.substr(0, max_name_bytes);
    const auto& pbr = from.pbrMetallicRoughness;
    const std::string pbr_place = place + ".pbrMetallicRoughness";
    for (glm::length_t i = 0; i < 4; ++i)
        to.base_color[i] = factor(pbr.baseColorFactor[static_cast<std::size_t>(i)], 1.0, pbr_place);
    to.metallic = factor(pbr.metallicFactor, 1.0, pbr_place);
    to.roughness = factor(pbr.roughnessFactor, 1.0, pbr_place);
    to.base_color_texture = texture_ref(document, pbr.baseColorTexture, pbr_place + ".baseColorTexture");
    to.metallic_roughness_texture =
        texture_ref(document, pbr.metallicRoughnessTexture, pbr_place + ".metallicRoughnessTexture");
    to.normal_texture = texture_ref(document, from.normalTexture, place + ".normalTexture");
    require(std::abs(from.normalTexture.scale) <= max_value, place + ".normalTexture.scale", "is not finite");
    to.normal_scale = static_cast<float>(from.normalTexture.scale);
    to.occlusion_texture = texture_ref(document, from.occlusionTexture, place + ".occlusionTexture");
    to.occlusion_strength = factor(from.occlusionTexture.strength, 1.0, place + ".occlusionTexture.strength");
    to.emissive_texture = texture_ref(document, from.emissiveTexture, place + ".emissiveTexture");
    for (glm::length_t i = 0; i < 3; ++i)
        to.emissive[i] = factor(from.emissiveFactor[static_cast<std::size_t>(i)], 1.0, place + ".emissiveFactor");
    to.emissive *= emissive_strength(from.extensions, place);
    to.alpha_mode = alpha_mode(from.alphaMode, place);
    to.alpha_cutoff = factor(from.alphaCutoff, 1e6, place + ".alphaCutoff");
    to.double_sided = from.doubleSided;
    to.unlit = from.extensions.contains("KHR_materials_unlit");
    let_through(from.extensions, place, to);
    return to;
}

Wrap wrap(int value, const std::string& place) {
    switch (value) {
        case TINYGLTF_TEXTURE_WRAP_REPEAT:
            return Wrap::repeat;
        case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
            return Wrap::clamp_to_edge;
        case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
            return Wrap::mirrored_repeat;
        default:
            fail(place, std::to_string(value) + " is no wrap mode");
    }
}

Sampler read_sampler(const tinygltf::Sampler& from, const std::string& place) {
    Sampler to{.wrap_s = wrap(from.wrapS, place + ".wrapS"), .wrap_t = wrap(from.wrapT, place + ".wrapT")};
    switch (from.magFilter) {
        case -1:
        case TINYGLTF_TEXTURE_FILTER_LINEAR:
            break;
        case TINYGLTF_TEXTURE_FILTER_NEAREST:
            to.magnify = Filter::nearest;
            break;
        default:
            fail(place + ".magFilter", std::to_string(from.magFilter) + " is no filter");
    }
    switch (from.minFilter) {
        case -1:
        case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR:
            break;
        case TINYGLTF_TEXTURE_FILTER_LINEAR:
            to.mipmaps = false;
            break;
        case TINYGLTF_TEXTURE_FILTER_NEAREST:
            to.mipmaps = false;
            to.minify = Filter::nearest;
            break;
        case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST:
            to.minify = Filter::nearest;
            to.between_mipmaps = Filter::nearest;
            break;
        case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_NEAREST:
            to.between_mipmaps = Filter::nearest;
            break;
        case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_LINEAR:
            to.minify = Filter::nearest;
            break;
        default:
            fail(place + ".minFilter", std::to_string(from.minFilter) + " is no filter");
    }
    return to;
}

std::size_t image_count(const Document& document) {
    const auto images = document.json.find("images");
    return images == document.json.end() ? 0 : images->size();
}

Image read_image(const Document& document, std::size_t index, Budget& budget) {
    const nlohmann::json& image = document.json["images"][index];
    const std::string place = item("images", index);
    if (const auto view = image.find("bufferView"); view != image.end())
        return decode_image(document.view(view->get<std::int64_t>(), place), place, budget);
    const auto uri = image.find("uri");
    require(uri != image.end() && uri->is_string(), place, "has neither bufferView nor uri");
    const auto bytes = load_uri(uri->get_ref<const std::string&>(), document.base, place + ".uri");
    return decode_image(bytes, place, budget);
}

}  // namespace

std::vector<Material> read_materials(const Document& document) {
    std::vector<Material> out;
    for (std::size_t i = 0; i < document.gltf.materials.size(); ++i) {
        const std::string place = item("materials", i);
        Material& made = out.emplace_back(read_material(document, document.gltf.materials[i], place));
        const auto& source = document.json["materials"][i];
        const nlohmann::json::json_pointer variants("/extras/camrig_variants");
        if (source.contains(variants))
            made.variants = read_variants(source[variants], place + ".extras.camrig_variants");
        // A look's color takes the place of the base color, but by a factor: it needs one.
        constexpr float least_color = 1e-4f;
        if (!made.variants.colors.empty())
            made.base_color = {glm::max(glm::vec3(made.base_color), least_color), made.base_color.a};
    }
    return out;
}

std::vector<Texture> read_textures(const Document& document) {
    std::vector<Sampler> samplers;
    for (std::size_t i = 0; i < document.gltf.samplers.size(); ++i)
        samplers.push_back(read_sampler(document.gltf.samplers[i], item("samplers", i)));
    std::vector<Texture> out;
    const std::size_t images = image_count(document);
    for (std::size_t i = 0; i < document.gltf.textures.size(); ++i) {
        const tinygltf::Texture& from = document.gltf.textures[i];
        const std::string place = item("textures", i);
        require(from.source < static_cast<std::int64_t>(images), place + ".source",
                "image " + std::to_string(from.source) + " of " + std::to_string(images));
        require(from.sampler < std::ssize(samplers), place + ".sampler",
                "sampler " + std::to_string(from.sampler) + " of " + std::to_string(samplers.size()));
        Texture texture;
        if (has_picture(from)) texture.image = from.source;  // else no material refers to it
        if (from.sampler >= 0) texture.sampler = samplers[static_cast<std::size_t>(from.sampler)];
        out.push_back(texture);
    }
    return out;
}

std::vector<Image> read_images(const Document& document, Budget& budget) {
    std::vector<Image> out(image_count(document));
    std::vector<bool> used(out.size());
    for (const tinygltf::Texture& texture : document.gltf.textures)
        if (has_picture(texture)) used[static_cast<std::size_t>(texture.source)] = true;
    for (std::size_t i = 0; i < out.size(); ++i)
        if (used[i]) out[i] = read_image(document, i, budget);
    return out;
}

}  // namespace camrig::world::gltf
