#include <gtest/gtest.h>

#include "tests/render/support/test_rig.h"

namespace camrig::render {
namespace {

/// 2x2 texels: red, green above blue, white.
world::Image four_colors() {
    return {.size = {2, 2}, .rgba = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 0}};
}

constexpr std::array red{255, 0, 0, 255};
constexpr std::array green{0, 255, 0, 255};
constexpr std::array blue{0, 0, 255, 255};

std::shared_ptr<world::Model> textured_wall(world::Sampler sampler = {.magnify = world::Filter::nearest,
                                                                      .minify = world::Filter::nearest}) {
    auto model = model_of(rectangle({2, 0, 0}, {0, -1, 0}, {0, 0, 1}), colored(glm::vec3(1.0f), true));
    model->images.push_back(four_colors());
    model->textures.push_back({.image = 0, .sampler = sampler});
    model->materials[0].base_color_texture.texture = 0;
    return model;
}

// The wall fills a 64x64 picture exactly.
const TestCamera camera{.size = {64, 64}, .focal_px = 64};

Picture draw_model(std::shared_ptr<world::Model> model) {
    TestWorld world;
    world.objects = {instance_of(std::move(model))};
    return draw(world, camera);
}

TEST(Texture, TheFirstTexelIsTopLeft) {
    const Picture picture = draw_model(textured_wall());
    EXPECT_EQ(picture.at(5, 5), red);
    EXPECT_EQ(picture.at(60, 5), green);
    EXPECT_EQ(picture.at(5, 60), blue);
    EXPECT_EQ(picture.at(31, 31), red);
    EXPECT_EQ(picture.at(32, 31), green);
}

TEST(Texture, WrapModesRepeatMirrorAndClamp) {
    const auto draw_wrapped = [](world::Wrap wrap) {
        auto model =
            textured_wall({.wrap_s = wrap, .magnify = world::Filter::nearest, .minify = world::Filter::nearest});
        for (auto& uv : model->meshes[0].primitives[0].texcoords[0]) uv.x *= 2.0f;  // two textures across
        return draw_model(model);
    };
    EXPECT_EQ(draw_wrapped(world::Wrap::repeat).at(36, 5), red);
    EXPECT_EQ(draw_wrapped(world::Wrap::mirrored_repeat).at(36, 5), green);
    EXPECT_EQ(draw_wrapped(world::Wrap::clamp_to_edge).at(60, 5), green);
}

TEST(Texture, TransformsScaleTurnAndShiftTheCoordinates) {
    auto shifted = textured_wall();
    shifted->materials[0].base_color_texture.offset = {0.5f, 0.0f};
    EXPECT_EQ(draw_model(shifted).at(5, 5), green);

    auto scaled = textured_wall();
    scaled->materials[0].base_color_texture.scale = {2.0f, 1.0f};
    EXPECT_EQ(draw_model(scaled).at(40, 5), red);

    // A quarter turn of the coordinates counter-clockwise shows the picture turned clockwise: blue comes to the top
    // left.
    auto turned = textured_wall();
    turned->materials[0].base_color_texture.rotation = 1.57079633f;
    EXPECT_EQ(draw_model(turned).at(5, 5), blue);
}

TEST(Texture, TheSecondCoordinateSetIsUsedWhereTheMaterialSaysSo) {
    auto model = textured_wall();
    auto& primitive = model->meshes[0].primitives[0];
    primitive.texcoords[1].assign(4, glm::vec2(0.75f, 0.25f));
    model->materials[0].base_color_texture.texcoord = 1;
    EXPECT_EQ(draw_model(model).at(5, 60), green);
}

TEST(Texture, AlphaMaskCutsHolesAtTheCutoff) {
    auto model = textured_wall();
    model->materials[0].alpha_mode = world::AlphaMode::mask;
    const Picture picture = draw_model(model);
    EXPECT_EQ(picture.at(60, 60), (std::array{0, 0, 0, 255}));
    EXPECT_EQ(picture.at(5, 5), red);
}

TEST(Texture, OpaqueIgnoresAlpha) {
    EXPECT_EQ(draw_model(textured_wall()).at(60, 60), (std::array{255, 255, 255, 255}));
}

TEST(Texture, ColourTexelsAreFilteredInLinearLight) {
    auto model =
        textured_wall({.wrap_s = world::Wrap::clamp_to_edge, .wrap_t = world::Wrap::clamp_to_edge, .mipmaps = false});
    const auto between = draw_model(model).at(32, 5);  // red and green, nearly half and half
    EXPECT_NEAR(between[0], srgb_code(0.5), 4);
    EXPECT_NEAR(between[1], srgb_code(0.5), 4);
}

TEST(Texture, EveryTexelValueOfAnUnlitTextureComesBackExactly) {
    auto model = textured_wall({.wrap_s = world::Wrap::clamp_to_edge,
                                .magnify = world::Filter::nearest,
                                .minify = world::Filter::nearest,
                                .mipmaps = false});
    world::Image ramp{.size = {256, 1}, .rgba = {}};
    for (int i = 0; i < 256; ++i) {
        for (const int value : {i, 255 - i, 128, 255}) ramp.rgba.push_back(static_cast<std::uint8_t>(value));
    }
    model->images[0] = ramp;
    TestWorld world;
    world.objects = {instance_of(model)};
    const Picture picture = draw(world, {.size = {256, 256}, .focal_px = 256});
    for (int i = 0; i < 256; ++i) EXPECT_EQ(picture.at(i, 100), (std::array{i, 255 - i, 128, 255}));
}

TEST(Texture, BaseEmissiveOcclusionAndMetalMapsAllWorkAtEveryQuality) {
    for (const world::Quality quality : {world::Quality::fast, world::Quality::simple, world::Quality::beautiful}) {
        auto model = textured_wall();
        world::Material& material = model->materials[0];
        material.unlit = false;
        material.emissive_texture = {.texture = 0, .offset = {0.5f, 0.0f}};
        material.emissive = glm::vec3(1.0f);
        material.occlusion_texture = material.base_color_texture;
        material.normal_texture = {.texture = 0, .scale = {3.0f, 1.0f}};
        material.metallic_roughness_texture = {.texture = 0, .texcoord = 1};
        model->meshes[0].primitives[0].texcoords[1] = model->meshes[0].primitives[0].texcoords[0];
        TestWorld world;
        world.objects = {instance_of(model)};
        world.lights = {light_of(world::LightType::directional, 1.0f, {}, {1, 0, 0}),
                        light_of(world::LightType::point, 1.0f, {1, 0, 0})};
        TestCamera view = camera;
        view.quality = quality;
        EXPECT_EQ(draw(world, view).at(5, 5)[1], 255);  // the green of the emissive map
    }
}

}  // namespace
}  // namespace camrig::render
