#include <cmath>

#include <gtest/gtest.h>

#include "tests/render/support/test_rig.h"

namespace camrig::render {
namespace {

constexpr world::Quality all_qualities[] = {world::Quality::fast, world::Quality::simple, world::Quality::beautiful};

/// A wall 2 m in front of the camera that fills the picture and faces it.
world::Primitive wall() {
    return rectangle({2, 0, 0}, {0, -4, 0}, {0, 0, 4});
}

TEST(Color, AnUnlitWallHasExactlyItsSrgbValue) {
    for (int code = 0; code < 256; code += 5) {
        TestWorld world;
        world.environment.ambient_sky = glm::vec3(0.0f);
        world.objects = {instance_of(model_of(wall(), colored(glm::vec3(static_cast<float>(linear_of(code))), true)))};
        EXPECT_EQ(draw(world, {.size = {16, 16}, .focal_px = 16}).red(8, 8), code);
    }
}

TEST(Color, AWallInFullAmbientLightHasItsOwnColour) {
    for (const world::Quality quality : {world::Quality::fast, world::Quality::simple}) {
        TestWorld world;
        world.objects = {instance_of(model_of(wall(), colored({0.5f, 0.2f, 0.05f})))};
        const auto pixel = draw(world, {.size = {16, 16}, .focal_px = 16, .quality = quality}).at(3, 12);
        EXPECT_EQ(pixel, (std::array{srgb_code(0.5), srgb_code(0.2), srgb_code(0.05), 255})) << int(quality);
    }
}

TEST(Color, TheFittedSrgbCurveIsNeverMoreThanOneCodeFromTheExactOne) {
    // 2048 greys, one strip of vertex colours each, most of them in the dark where the curve is steep.
    constexpr int greys = 2048;
    world::Primitive strips;
    for (int i = 0; i < greys; ++i) {
        const float left = static_cast<float>(i) / greys * 64.0f - 32.0f;
        const auto base = static_cast<std::uint32_t>(strips.positions.size());
        const world::Primitive strip = rectangle({32.0f, -left - 32.0f / greys, 0}, {0, -32.0f / greys, 0}, {0, 0, 32});
        strips.positions.insert(strips.positions.end(), strip.positions.begin(), strip.positions.end());
        const float x = static_cast<float>(i) / (greys - 1);
        strips.colors.insert(strips.colors.end(), 4, glm::vec4(glm::vec3(x * x * x), 1.0f));
        for (const auto index : strip.indices) strips.indices.push_back(base + index);
    }
    TestWorld world;
    world.objects = {instance_of(model_of(std::move(strips), colored(glm::vec3(1.0f), true)))};
    const Picture picture = draw(world, {.size = {greys, 16}, .focal_px = greys / 2.0});
    int off_by_one = 0;
    for (int i = 0; i < greys; ++i) {
        const double x = static_cast<double>(i) / (greys - 1);
        const int difference = std::abs(picture.red(i, 8) - srgb_code(x * x * x));
        ASSERT_LE(difference, 1) << i;
        off_by_one += difference;
    }
    EXPECT_LT(off_by_one, greys / 20);
}

TEST(Color, TheBackgroundIsTheEnvironmentsTimesExposure) {
    TestWorld world;
    world.environment.background = {0.1f, 0.3f, 0.8f};
    world.environment.exposure = 0.5f;
    const auto pixel = draw(world, {}).at(5, 5);
    EXPECT_EQ(pixel, (std::array{srgb_code(0.05), srgb_code(0.15), srgb_code(0.4), 255}));
}

TEST(Color, DirectionalLightFollowsTheCosine) {
    for (const world::Quality quality : {world::Quality::fast, world::Quality::simple}) {
        TestWorld world;
        world.environment.ambient_sky = world.environment.ambient_ground = glm::vec3(0.0f);
        const double angle = 1.0471975511965976;
        world.lights = {light_of(world::LightType::directional, 0.8f, {}, {std::cos(angle), std::sin(angle), 0.0})};
        world.objects = {instance_of(model_of(wall(), colored(glm::vec3(1.0f))))};
        EXPECT_NEAR(draw(world, {.quality = quality}).red(32, 24), srgb_code(0.4), 1);
    }
}

TEST(Color, PointLightFallsWithTheSquareOfTheDistanceAndEndsAtItsRange) {
    TestWorld world;
    world.environment.ambient_sky = world.environment.ambient_ground = glm::vec3(0.0f);
    world.objects = {instance_of(model_of(wall(), colored(glm::vec3(1.0f))))};
    const TestCamera camera{.size = {65, 49}};
    for (const float range : {0.0f, 1.5f, 3.0f}) {
        world.lights = {light_of(world::LightType::point, 0.6f, {1, 0, 0})};
        world.lights[0].range = range;
        const Picture picture = draw(world, camera);
        for (int x = 2; x < 65; x += 10) {
            // The wall is 2 m away, the light 1 m in front of it.
            const double y = (x - 32) / 64.0 * 2.0;
            const double d2 = 1.0 + y * y;
            const double window = range > 0 ? std::clamp(1.0 - d2 * d2 / std::pow(range, 4.0), 0.0, 1.0) : 1.0;
            EXPECT_NEAR(picture.red(x, 24), srgb_code(0.6 * window / d2 / std::sqrt(d2)), 1) << range << " " << x;
        }
    }
}

TEST(Color, SpotLightFadesBetweenItsCones) {
    TestWorld world;
    world.environment.ambient_sky = world.environment.ambient_ground = glm::vec3(0.0f);
    world.objects = {instance_of(model_of(wall(), colored(glm::vec3(1.0f))))};
    world::Light spot = light_of(world::LightType::spot, 0.9f, {1, 0, 0}, {1, 0, 0});
    spot.inner_cone_rad = 0.2f;
    spot.outer_cone_rad = 0.6f;
    world.lights = {spot};
    const Picture picture = draw(world, {.size = {65, 49}});
    for (int x = 2; x < 65; x += 5) {
        const double y = (x - 32) / 64.0 * 2.0;
        const double d2 = 1.0 + y * y;
        const double cosine = 1.0 / std::sqrt(d2);
        const double fade = std::clamp((cosine - std::cos(0.6)) / (std::cos(0.2) - std::cos(0.6)), 0.0, 1.0);
        EXPECT_NEAR(picture.red(x, 24), srgb_code(0.9 * fade * fade * cosine / d2), 1) << x;
    }
}

TEST(Color, HemisphereLightsUpwardFacesFromTheSkyAndDownwardOnesFromTheGround) {
    TestWorld world;
    world.environment.ambient_sky = glm::vec3(0.8f);
    world.environment.ambient_ground = glm::vec3(0.2f);
    world.objects = {instance_of(model_of(wall(), colored(glm::vec3(1.0f))))};
    EXPECT_NEAR(draw(world, {}).red(32, 24), srgb_code(0.5), 1);  // a vertical wall sees both halves
    world.objects = {instance_of(model_of(rectangle({3, 0, -1}, {2, 0, 0}, {0, 2, 0}), colored(glm::vec3(1.0f))))};
    EXPECT_NEAR(draw(world, {}).red(32, 45), srgb_code(0.8), 1);
}

TEST(Color, EmissiveAddsToTheLight) {
    TestWorld world;
    world::Material material = colored(glm::vec3(0.1f));
    material.emissive = {0.3f, 0.0f, 0.0f};
    world.objects = {instance_of(model_of(wall(), material))};
    const auto pixel = draw(world, {}).at(10, 10);
    EXPECT_EQ(pixel, (std::array{srgb_code(0.4), srgb_code(0.1), srgb_code(0.1), 255}));
}

TEST(Color, BlendingIsLinearLightAndKeepsThePictureOpaque) {
    for (const world::Quality quality : all_qualities) {
        TestWorld world;
        world.environment.background = {0.2f, 0.2f, 0.2f};
        world::Material glass = colored({1.0f, 1.0f, 1.0f});
        glass.base_color.a = 0.25f;
        glass.alpha_mode = world::AlphaMode::blend;
        world.objects = {instance_of(model_of(wall(), glass))};
        const auto pixel = draw(world, {.quality = quality}).at(10, 10);
        EXPECT_NEAR(pixel[0], srgb_code(0.25 + 0.75 * 0.2), 1);
        EXPECT_EQ(pixel[3], 255);
    }
}

TEST(Color, BlendedSurfacesAreDrawnFarthestFirst) {
    TestWorld world;
    world::Material red = colored({1, 0, 0}, true);
    world::Material green = colored({0, 1, 0}, true);
    red.base_color.a = green.base_color.a = 0.5f;
    red.alpha_mode = green.alpha_mode = world::AlphaMode::blend;
    // The nearer one comes first in the list.
    world.objects = {instance_of(model_of(rectangle({2, 0, 0}, {0, -4, 0}, {0, 0, 4}), red), {}, 1),
                     instance_of(model_of(rectangle({3, 0, 0}, {0, -9, 0}, {0, 0, 9}), green), {}, 2)};
    const auto pixel = draw(world, {}).at(10, 10);
    EXPECT_NEAR(pixel[0], srgb_code(0.5), 1);
    EXPECT_NEAR(pixel[1], srgb_code(0.25), 1);
}

}  // namespace
}  // namespace camrig::render
