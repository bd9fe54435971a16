// Light that is neither a lamp's nor a surface's: what bodies keep from what is beside them, fog, and the exposure of
// a camera.

#include <cmath>

#include <gtest/gtest.h>

#include "core/world/model_lights.h"
#include "tests/render/support/test_body.h"
#include "tests/render/support/test_rig.h"

namespace camrig::render {
namespace {

constexpr world::Quality all_qualities[] = {world::Quality::fast, world::Quality::simple, world::Quality::beautiful};

struct Pixel {
    int x, y;
};
/// Where the camera sees a point.
Pixel pixel_of(const TestCamera& camera, const glm::dvec3& point) {
    return {static_cast<int>(std::lround(0.5 * (camera.size.width - 1) - camera.focal_px * point.y / point.x)),
            static_cast<int>(std::lround(0.5 * (camera.size.height - 1) - camera.focal_px * point.z / point.x))};
}

world::Material rough(glm::vec3 color) {
    world::Material material = colored(color);
    material.roughness = 1.0f;
    material.metallic = 0.0f;
    return material;
}

/// A floor at z = -1 and a wall behind it, and somebody on the floor; all around is light of 0.5.
TestWorld hall_with(world::ModelRef body, glm::dvec3 where) {
    TestWorld world;
    world.environment.ambient_sky = world.environment.ambient_ground = glm::vec3(0.5f);
    world.objects = {instance_of(model_of(rectangle({6, 0, -1}, {6, 0, 0}, {0, 6, 0}), rough(glm::vec3(0.8f))), {}, 1),
                     instance_of(model_of(rectangle({8, 0, 1}, {0, -6, 0}, {0, 0, 3}), rough(glm::vec3(0.8f))), {}, 2)};
    if (body != nullptr) world.movers = {instance_of(std::move(body), where, 3)};
    return world;
}
const TestCamera hall_camera{.size = {320, 240}, .focal_px = 280.0, .quality = world::Quality::beautiful};

TEST(Bodies, DarkenTheFloorAndTheWallBesideThem) {
    const Picture without = draw(hall_with(nullptr, {}), hall_camera);
    const Picture with = draw(hall_with(leg_and_cube(), {5, 0, -1}), hall_camera);
    const auto kept = [&](const glm::dvec3& point) {
        const auto [x, y] = pixel_of(hall_camera, point);
        return linear_of(with.red(x, y)) / linear_of(without.red(x, y));
    };
    EXPECT_LT(kept({5, 0.17, -1}), 0.85) << "beside the foot";
    EXPECT_LT(kept({5, 0.17, -1}), kept({5, 0.35, -1})) << "less so farther away";
    EXPECT_LT(kept({5, 0.35, -1}), 0.97);
    EXPECT_EQ(kept({5, 0.9, -1}), 1.0) << "and not beyond their reach";
    EXPECT_EQ(kept({8, 2.0, -0.2}), 1.0);
    const Picture at_wall = draw(hall_with(leg_and_cube(), {7.75, 0, -1}), hall_camera);
    const auto [x, y] = pixel_of(hall_camera, {8, 0.35, 0.0});
    EXPECT_LT(linear_of(at_wall.red(x, y)), 0.97 * linear_of(without.red(x, y))) << "the wall behind the cube";
}

TEST(Bodies, KeepNothingOfTheSunsLight) {
    TestWorld dark = hall_with(leg_and_cube(), {5, 0, -1});
    dark.environment.ambient_sky = dark.environment.ambient_ground = glm::vec3(0.0f);
    // From the left: what lies to the left of the body has no shadow.
    dark.lights = {light_of(world::LightType::directional, 0.8f, {}, glm::normalize(glm::dvec3(0.0, -1.0, -1.0)))};
    const Picture picture = draw(dark, hall_camera);
    const auto red = [&](const glm::dvec3& point) {
        const auto [x, y] = pixel_of(hall_camera, point);
        return picture.red(x, y);
    };
    EXPECT_EQ(red({5, 0.3, -1}), red({5, 1.5, -1}));
    EXPECT_EQ(red({5, -0.4, -1}), 0) << "in the shadow";
}

TEST(Bodies, AreDarkenedByOthersAndNotByThemselves) {
    const auto darkest = [&](const TestWorld& world) {
        const auto [x, y] = pixel_of(hall_camera, {4.8, 0.0, 0.0});  // the cube's front
        return draw(world, hall_camera).red(x, y);
    };
    TestWorld alone = hall_with(leg_and_cube(), {5, 0, -1}), two = alone;
    const int own = darkest(alone);
    two.movers.push_back(instance_of(leg_and_cube(), {4.6, 0.45, -1}, 4));
    EXPECT_LT(darkest(two), own);
    // Rigid boxes of the same shape have the light that the body has, also below the cube, which sees the leg.
    TestWorld above = hall_with(leg_and_cube(), {5, 0, 1}), boxes = above;
    boxes.movers = {instance_of(model_of(box({0.2f, 0.2f, 0.2f}), colored(glm::vec3(0.5f))), {5, 0, 2.0}, 3),
                    instance_of(model_of(box({0.1f, 0.1f, 0.4f}), colored(glm::vec3(0.5f))), {5, 0, 1.4}, 4)};
    const auto [x, y] = pixel_of(hall_camera, {4.86, 0.0, 1.8});
    EXPECT_EQ(draw(above, hall_camera).red(x, y), draw(boxes, hall_camera).red(x, y));
}

TEST(Fog, LeavesOfEachSurfaceWhatKoschmiederSays) {
    for (const world::Quality quality : all_qualities) {
        for (const double distance : {2.0, 10.0, 40.0}) {
            TestWorld world;
            world.environment.background = {0.02f, 0.03f, 0.04f};
            world.objects = {instance_of(
                model_of(rectangle({0, 0, 0}, {0, -100, 0}, {0, 0, 0.1}), colored({0.9f, 0.2f, 0.05f}, true)),
                {distance, 0, 0})};
            world.environment.fog = {.visibility_m = 30.0, .color = glm::vec3(0.3f, 0.35f, 0.4f)};
            const TestCamera camera{.size = {129, 65}, .focal_px = 60.0, .quality = quality};
            const Picture picture = draw(world, camera);
            for (const int x : {4, 64, 120}) {
                const double ray = std::hypot(1.0, (x - 64) / 60.0);
                const double left = std::exp(-3.912 * distance * ray / 30.0);
                EXPECT_NEAR(picture.red(x, 32), srgb_code(0.3 + (0.9 - 0.3) * left), 1) << distance << " " << x;
                EXPECT_NEAR(picture.at(x, 32)[2], srgb_code(0.4 + (0.05 - 0.4) * left), 1) << distance << " " << x;
            }
            EXPECT_NEAR(picture.red(64, 1), srgb_code(0.3), 1) << "where nothing is, it has no end";
        }
    }
}

TEST(Fog, LiesOnLitAndBlendedSurfacesAndIsTheBackgroundsColour) {
    for (const world::Quality quality : all_qualities) {
        TestWorld world;
        world.environment.background = {0.4f, 0.4f, 0.4f};
        world.environment.ambient_sky = world.environment.ambient_ground = glm::vec3(0.7f);
        world::Material glass = colored({1.0f, 1.0f, 1.0f}, true);
        glass.alpha_mode = world::AlphaMode::blend;
        glass.base_color.a = 0.25f;
        world.objects = {instance_of(model_of(rectangle({10, 0, 0}, {0, -30, 0}, {0, 0, 30}), rough(glm::vec3(0.5f))))};
        const TestCamera camera{.size = {65, 65}, .focal_px = 60.0, .quality = quality};
        const double wall = linear_of(draw(world, camera).red(32, 32));
        world.objects.push_back(instance_of(model_of(rectangle({5, 0, 0}, {0, -30, 0}, {0, 0, 30}), glass), {}, 2));
        world.environment.fog.visibility_m = 40.0;
        const double at_5 = std::exp(-3.912 * 5 / 40), at_10 = std::exp(-3.912 * 10 / 40);
        const double behind = 0.4 + (wall - 0.4) * at_10, glassy = 0.4 + (1.0 - 0.4) * at_5;
        EXPECT_NEAR(draw(world, camera).red(32, 32), srgb_code(0.25 * glassy + 0.75 * behind), 2) << int(quality);
    }
}

TEST(Fog, ChangesNeitherDepthNorIdsAndWithoutVisibilityThereIsNone) {
    TestWorld world = hall_with(leg_and_cube(), {5, 0, -1}), foggy = world, none = world;
    foggy.environment.fog = {.visibility_m = 5.0, .color = glm::vec3(1.0f)};
    none.environment.fog = {.visibility_m = 0.0, .color = glm::vec3(1.0f)};
    for (const auto kind : {frame::FrameKind::depth, frame::FrameKind::instance, frame::FrameKind::normal}) {
        const frame::FrameRef clear = draw_kind(world, hall_camera, kind), misty = draw_kind(foggy, hall_camera, kind);
        EXPECT_TRUE(std::ranges::equal(clear->bytes(), misty->bytes()));
    }
    const Picture clear = draw(world, hall_camera);
    EXPECT_TRUE(std::ranges::equal(clear.frame->bytes(), draw(none, hall_camera).frame->bytes()));
    EXPECT_FALSE(std::ranges::equal(clear.frame->bytes(), draw(foggy, hall_camera).frame->bytes()));
}

TEST(ExposureOfACamera, IsAFactorBesideThatOfTheScene) {
    for (const world::Quality quality : all_qualities) {
        TestWorld world = hall_with(leg_and_cube(), {5, 0, -1});
        world.environment.background = {0.05f, 0.1f, 0.2f};
        world.environment.ambient_sky = world.environment.ambient_ground = glm::vec3(0.1f);
        world.environment.fog.visibility_m = 60.0;
        world.lights = {light_of(world::LightType::directional, 0.1f, {}, glm::normalize(glm::dvec3(0.3, -1.0, -1.0)))};
        world::Material lamp = colored(glm::vec3(0.1f));
        lamp.emissive = {0.05f, 0.04f, 0.02f};
        world.objects.push_back(instance_of(model_of(box(glm::vec3(0.2f)), lamp), {5, 1, 0}, 9));
        world.objects.push_back(
            instance_of(model_of(box(glm::vec3(0.2f)), colored(glm::vec3(0.1f), true)), {5, -1, 0}, 10));
        TestCamera camera = hall_camera;
        camera.quality = quality;
        View view = camera.view();
        auto spec = std::make_shared<world::CameraSpec>(*view.spec);
        spec->exposure_ev = 2.0;
        view.spec = spec;
        const frame::FrameRef by_camera = draw_views(world.snapshot(), {&view, 1}).at(0);
        const frame::FrameRef before = draw_views(world.snapshot(), std::vector{camera.view(2)}).at(0);
        world.environment.exposure = 4.0f;
        const frame::FrameRef by_scene = draw_views(world.snapshot(), std::vector{camera.view(3)}).at(0);
        EXPECT_TRUE(std::ranges::equal(by_camera->bytes(), by_scene->bytes())) << int(quality);
        EXPECT_FALSE(std::ranges::equal(by_camera->bytes(), before->bytes()));
    }
}

}  // namespace
}  // namespace camrig::render
