#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/world/gltf_loader.h"
#include "tests/unit/world/glb_builder.h"

namespace camrig::world::gltf_material_test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// One red pixel.
constexpr const char* red_png =
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4"
    "2mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==";

/// A triangle with this material, and three textures of one picture.
GlbBuilder with_material(json material) {
    GlbBuilder glb;
    glb.mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{"material", 0}});
    glb.json["images"] = {{{"uri", red_png}}};
    glb.json["textures"] = {{{"source", 0}}, {{"source", 0}}, {{"source", 0}}};
    glb.json["materials"] = json::array({std::move(material)});
    return glb;
}

Result<ModelRef> load(const GlbBuilder& builder) {
    return load_model(builder.build(), {}, "test");
}

std::string error_of(const GlbBuilder& builder) {
    const auto model = load(builder);
    return model ? "loaded" : model.error().message;
}

TEST(GltfMaterials, AnEmptyMaterialHasTheStandardsDefaults) {
    const auto model = load(with_material(json::object()));
    ASSERT_TRUE(model) << model.error().message;
    const Material& m = (*model)->materials[0];
    EXPECT_EQ(m.base_color, glm::vec4(1.0f));
    EXPECT_EQ(m.metallic, 1.0f);
    EXPECT_EQ(m.roughness, 1.0f);
    EXPECT_EQ(m.emissive, glm::vec3(0.0f));
    EXPECT_EQ(m.alpha_mode, AlphaMode::opaque);
    EXPECT_EQ(m.alpha_cutoff, 0.5f);
    EXPECT_FALSE(m.double_sided);
    EXPECT_FALSE(m.unlit);
    for (const TextureRef& ref : {m.base_color_texture, m.metallic_roughness_texture, m.normal_texture,
                                  m.occlusion_texture, m.emissive_texture})
        EXPECT_EQ(ref.texture, -1);
}

TEST(GltfMaterials, EveryFieldIsRead) {
    const auto model = load(with_material(json::parse(R"({
        "name": "wood", "emissiveFactor": [0.1, 0.2, 0.3], "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.75,
                                 "baseColorTexture": {"index": 0, "texCoord": 1}, "metallicRoughnessTexture": {"index": 1}},
        "normalTexture": {"index": 2, "scale": 0.5}, "occlusionTexture": {"index": 1, "strength": 0.25},
        "emissiveTexture": {"index": 2, "texCoord": 1}, "extensions": {"KHR_materials_unlit": {}, "KHR_materials_emissive_strength": {"emissiveStrength": 4.5}}})")));
    ASSERT_TRUE(model) << model.error().message;
    const Material& m = (*model)->materials[0];
    EXPECT_EQ(m.name, "wood");
    EXPECT_EQ(m.base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
    EXPECT_EQ(m.emissive, glm::vec3(0.1f, 0.2f, 0.3f) * 4.5f);
    EXPECT_EQ(m.metallic, 0.5f);
    EXPECT_EQ(m.roughness, 0.75f);
    EXPECT_EQ(m.normal_scale, 0.5f);
    EXPECT_EQ(m.occlusion_strength, 0.25f);
    EXPECT_EQ(m.alpha_mode, AlphaMode::mask);
    EXPECT_EQ(m.alpha_cutoff, 0.25f);
    EXPECT_TRUE(m.double_sided);
    EXPECT_TRUE(m.unlit);
    EXPECT_EQ(m.base_color_texture.texture, 0);
    EXPECT_EQ(m.base_color_texture.texcoord, 1);
    EXPECT_EQ(m.metallic_roughness_texture.texture, 1);
    EXPECT_EQ(m.normal_texture.texture, 2);
    EXPECT_EQ(m.occlusion_texture.texture, 1);
    EXPECT_EQ(m.emissive_texture.texture, 2);
    EXPECT_EQ(m.emissive_texture.texcoord, 1);
}

TEST(GltfMaterials, FactorsOutOfRangeAreClamped) {
    const auto model = load(with_material(
        {{"pbrMetallicRoughness", {{"metallicFactor", 2}, {"roughnessFactor", -1}}}, {"emissiveFactor", {7, 0, -1}}}));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ((*model)->materials[0].metallic, 1.0f);
    EXPECT_EQ((*model)->materials[0].roughness, 0.0f);
    EXPECT_EQ((*model)->materials[0].emissive, glm::vec3(1, 0, 0));
}

TEST(GltfMaterials, ShineAsStronglyAsTheirExtensionSays) {
    const auto shining = [](const json& strength) {
        return load(
            with_material({{"emissiveFactor", {1, 0.5, 0}},
                           {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", strength}}}}}}));
    };
    const auto model = shining(4);
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ((*model)->materials[0].emissive, glm::vec3(4, 2, 0));
    const auto wrong = shining("much");
    ASSERT_FALSE(wrong);
    EXPECT_THAT(wrong.error().message, HasSubstr("emissiveStrength: expected a number"));
}

TEST(GltfMaterials, OfGlassAreBlendedByWhatTheyLetThrough) {
    const auto glass = [](const json& factor) {
        return load(
            with_material({{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 1, 0.75, 1}}}},
                           {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", factor}}}}}}));
    };
    const auto model = glass(0.8);
    ASSERT_TRUE(model) << model.error().message;
    const Material& m = (*model)->materials[0];
    EXPECT_EQ(m.alpha_mode, AlphaMode::blend);
    EXPECT_EQ(m.transmission, 0.8f);
    // 0.8 of a mean of 0.75 goes through; a fifth of the light is scattered.
    EXPECT_NEAR(m.base_color.a, 0.4, 1e-6);
    EXPECT_NEAR(m.base_color.g * m.base_color.a, 0.2, 1e-6);
    EXPECT_NEAR(m.base_color.r * m.base_color.a, 0.1, 1e-6);
    const glm::vec3 through = (1.0f - m.base_color.a) * m.tint;
    EXPECT_NEAR(through.r, 0.4, 1e-6);
    EXPECT_NEAR(through.g, 0.8, 1e-6);
    EXPECT_NEAR(through.b, 0.6, 1e-6);
    const auto none = glass(0);
    ASSERT_TRUE(none);
    EXPECT_EQ((*none)->materials[0].alpha_mode, AlphaMode::opaque);
    EXPECT_EQ((*none)->materials[0].base_color, glm::vec4(0.5f, 1.0f, 0.75f, 1.0f));
    const auto wrong = glass("all");
    ASSERT_FALSE(wrong);
    EXPECT_THAT(wrong.error().message, HasSubstr("transmissionFactor: expected a number"));
}

TEST(GltfMaterials, GlassHasTheAlphaThatItsModeHas) {
    const auto glass = [](const char* mode) {
        auto model =
            load(with_material({{"alphaMode", mode},
                                {"alphaCutoff", 0.25},
                                {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.5}}}},
                                {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0.8}}}}}}));
        return (*model.value()).materials[0];
    };
    EXPECT_NEAR(glass("OPAQUE").base_color.a, 0.2, 1e-6) << "its alpha counts for nothing";
    EXPECT_NEAR(glass("BLEND").base_color.a, 0.1, 1e-6);
    EXPECT_EQ(glass("MASK").alpha_mode, AlphaMode::mask) << "what is cut out is cut out";
    EXPECT_EQ(glass("MASK").base_color, glm::vec4(1.0f, 1.0f, 1.0f, 0.5f));
    EXPECT_EQ(glass("MASK").tint, glm::vec3(1.0f));
    EXPECT_EQ(glass("BLEND").tint, glm::vec3(1.0f));
}

json base_texture(json info) {
    return {{"pbrMetallicRoughness", {{"baseColorTexture", std::move(info)}}}};
}

TEST(GltfMaterials, TextureTransformIsFoldedIntoTheReference) {
    auto glb = with_material(base_texture(json::parse(
        R"({"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform":
            {"offset": [0.5, -1], "scale": [2, 3], "rotation": 1.25, "texCoord": 1}}})")));
    glb.json["extensionsRequired"] = glb.json["extensionsUsed"] = {"KHR_texture_transform"};
    const auto model = load(glb);
    ASSERT_TRUE(model) << model.error().message;
    const TextureRef& ref = (*model)->materials[0].base_color_texture;
    EXPECT_EQ(ref.offset, glm::vec2(0.5f, -1.0f));
    EXPECT_EQ(ref.scale, glm::vec2(2.0f, 3.0f));
    EXPECT_EQ(ref.rotation, 1.25f);
    EXPECT_EQ(ref.texcoord, 1);
}

TEST(GltfMaterials, TextureTransformsOfWrongFormAreErrors) {
    const auto message = [](json transform) {
        return error_of(with_material(
            base_texture({{"index", 0}, {"extensions", {{"KHR_texture_transform", std::move(transform)}}}})));
    };
    const std::string place = "materials[0].pbrMetallicRoughness.baseColorTexture.extensions.KHR_texture_transform.";
    EXPECT_THAT(message({{"offset", {1}}}), HasSubstr(place + "offset: expected an array of 2 numbers"));
    EXPECT_THAT(message({{"scale", {1, "x"}}}), HasSubstr(place + "scale"));
    EXPECT_THAT(message({{"rotation", 1e30}}), HasSubstr(place + "rotation: expected a number within 1e6"));
    EXPECT_THAT(message({{"texCoord", 2}}), HasSubstr("texture coordinate sets 0 and 1 are read"));
}

TEST(GltfMaterials, WrongMaterialsAreErrorsWithTheirPlace) {
    EXPECT_THAT(error_of(with_material(base_texture({{"index", 3}}))),
                HasSubstr("materials[0].pbrMetallicRoughness.baseColorTexture.index: texture 3 of 3"));
    EXPECT_THAT(error_of(with_material({{"normalTexture", {{"index", 0}, {"texCoord", 2}}}})),
                HasSubstr("materials[0].normalTexture.texCoord"));
    EXPECT_THAT(error_of(with_material({{"alphaMode", "GLASS"}})), HasSubstr("materials[0].alphaMode: 'GLASS'"));
    auto glb = with_material(json::object());
    glb.json["meshes"][0]["primitives"][0]["material"] = 1;
    EXPECT_THAT(error_of(glb), HasSubstr("meshes[0].primitives[0].material: material 1 of 1"));
}

TEST(GltfTextures, SamplersMeanWhatTheStandardSays) {
    auto glb = with_material(json::object());
    glb.json["samplers"] = json::array({json::object()});
    for (int filter = 9984; filter <= 9987; ++filter)
        glb.json["samplers"].push_back({{"minFilter", filter}, {"magFilter", 9728}});
    for (int filter = 9728; filter <= 9729; ++filter)
        glb.json["samplers"].push_back(
            {{"minFilter", filter}, {"magFilter", 9729}, {"wrapS", 33071}, {"wrapT", 33648}});
    glb.json["textures"] = json::array();
    for (int s = 0; s < 7; ++s) glb.json["textures"].push_back({{"source", 0}, {"sampler", s}});
    const auto model = load(glb);
    ASSERT_TRUE(model) << model.error().message;
    const auto sampler = [&](std::size_t i) { return (*model)->textures[i].sampler; };

    EXPECT_EQ(sampler(0).wrap_s, Wrap::repeat);
    EXPECT_EQ(sampler(0).magnify, Filter::linear);
    EXPECT_TRUE(sampler(0).mipmaps);
    // NEAREST_MIPMAP_NEAREST, LINEAR_MIPMAP_NEAREST, NEAREST_MIPMAP_LINEAR, LINEAR_MIPMAP_LINEAR
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_TRUE(sampler(i + 1).mipmaps) << i;
        EXPECT_EQ(sampler(i + 1).minify, i % 2 == 0 ? Filter::nearest : Filter::linear) << i;
        EXPECT_EQ(sampler(i + 1).between_mipmaps, i < 2 ? Filter::nearest : Filter::linear) << i;
        EXPECT_EQ(sampler(i + 1).magnify, Filter::nearest) << i;
    }
    EXPECT_FALSE(sampler(5).mipmaps);
    EXPECT_EQ(sampler(5).minify, Filter::nearest);
    EXPECT_FALSE(sampler(6).mipmaps);
    EXPECT_EQ(sampler(6).minify, Filter::linear);
    EXPECT_EQ(sampler(6).wrap_s, Wrap::clamp_to_edge);
    EXPECT_EQ(sampler(6).wrap_t, Wrap::mirrored_repeat);
}

TEST(GltfTextures, WrongSamplersAndSourcesAreErrors) {
    const auto message = [](json sampler, json texture) {
        auto glb = with_material(json::object());
        glb.json["samplers"] = json::array({std::move(sampler)});
        glb.json["textures"] = json::array({std::move(texture)});
        return error_of(glb);
    };
    EXPECT_THAT(message({{"wrapS", 5}}, {{"source", 0}}), HasSubstr("samplers[0].wrapS: 5 is no wrap mode"));
    EXPECT_THAT(message({{"minFilter", 5}}, {{"source", 0}}), HasSubstr("samplers[0].minFilter: 5 is no filter"));
    EXPECT_THAT(message({{"magFilter", 9987}}, {{"source", 0}}), HasSubstr("samplers[0].magFilter"));
    EXPECT_THAT(message(json::object(), {{"source", 1}}), HasSubstr("textures[0].source: image 1 of 1"));
    EXPECT_THAT(message(json::object(), {{"source", 0}, {"sampler", 1}}), HasSubstr("textures[0].sampler: sampler 1"));
}

TEST(GltfTextures, ATextureWithoutASourceIsNoTexture) {
    auto glb = with_material(
        {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 1}}}}}, {"normalTexture", {{"index", 2}}}});
    glb.json["textures"][1] = {{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}};
    const auto model = load(glb);
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ((*model)->materials[0].base_color_texture.texture, -1);
    EXPECT_EQ((*model)->materials[0].normal_texture.texture, 2);
}

TEST(GltfTextures, APictureNoTextureUsesIsNotRead) {
    auto glb = with_material(json::object());
    glb.json["images"].push_back({{"uri", "only-for-an-extension.ktx2"}});
    const auto model = load(glb);
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_TRUE((*model)->images[1].rgba.empty());
}

}  // namespace
}  // namespace camrig::world::gltf_material_test
