#include "core/render/lens_plan.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace camrig::render {
namespace {

struct Optics {
    const char* name;
    camera::Lens lens;
    camera::Intrinsics intrinsics;
    world::LensMethod expected;
};

constexpr ImageSize vga{640, 480};
const Optics all_optics[] = {
    {"pinhole", {camera::LensModel::pinhole, {}}, {500, 510, 320.25, 239.5}, world::LensMethod::warp},
    {"barrel",
     {camera::LensModel::plumb_bob, {-0.35, 0.15, 0, 0, -0.03}},
     {420, 420, 319.5, 239.5},
     world::LensMethod::warp},
    {"pincushion",
     {camera::LensModel::plumb_bob, {0.3, 0.1, 0, 0, 0.02}},
     {450, 450, 319.5, 239.5},
     world::LensMethod::warp},
    {"tangential",
     {camera::LensModel::plumb_bob, {-0.1, 0.02, 0.012, -0.009, 0}},
     {480, 480, 319.5, 239.5},
     world::LensMethod::warp},
    {"fold",
     {camera::LensModel::plumb_bob, {-0.32, 0.13, 0, 0, -0.025}},
     {380, 380, 319.5, 239.5},
     world::LensMethod::warp},
    {"fisheye 160", {camera::LensModel::equidistant, {0, 0, 0, 0}}, {290, 290, 319.5, 239.5}, world::LensMethod::cube},
    {"fisheye 220",
     {camera::LensModel::equidistant, {-0.01, 0.002, 0, 0}},
     {208, 210, 330.5, 235.5},
     world::LensMethod::cube},
};

camera::CameraModel camera_of(const Optics& optics) {
    return camera::CameraModel::create(vga, optics.intrinsics, optics.lens).value();
}

const SourceTile* tile_at(const LensPlan& plan, glm::dvec2 place) {
    for (const SourceTile& tile : plan.tiles) {
        if (place.x >= tile.x && place.y >= tile.y && place.x <= tile.x + tile.size.width - 1 &&
            place.y <= tile.y + tile.size.height - 1) {
            return &tile;
        }
    }
    return nullptr;
}

glm::dvec2 place_of(const LensPlan& plan, std::size_t i) {
    return glm::dvec2(plan.map[i]) / double(1 << LensPlan::fraction_bits);
}

/// The ray that a source place was drawn for.
glm::dvec3 ray_of(const SourceTile& tile, glm::dvec2 place) {
    const camera::Intrinsics& k = tile.intrinsics;
    const glm::dvec3 ray((place.x - tile.x - k.cx) / k.fx, (place.y - tile.y - k.cy) / k.fy, 1.0);
    return glm::transpose(tile.tile_from_optical) * glm::normalize(ray);
}

TEST(LensPlan, EveryPixelLooksExactlyAlongItsRayAndFarEnoughFromTheTilesEdge) {
    for (const Optics& optics : all_optics) {
        const camera::CameraModel camera = camera_of(optics);
        const auto plan = make_lens_plan(camera, {}, {});
        ASSERT_TRUE(plan) << optics.name << ": " << plan.error().message;
        EXPECT_EQ(plan->method, optics.expected) << optics.name;
        for (int y = 0; y < vga.height; ++y) {
            for (int x = 0; x < vga.width; ++x) {
                const std::size_t i = static_cast<std::size_t>(y * vga.width + x);
                const auto ray = camera.ray({x, y});
                ASSERT_EQ(ray.has_value(), plan->map[i] != LensPlan::nowhere) << optics.name << x << "," << y;
                if (!ray) continue;
                const glm::dvec2 place = place_of(*plan, i);
                const SourceTile* tile = tile_at(*plan, place);
                ASSERT_NE(tile, nullptr) << optics.name;
                // A pixel is 2e-3 rad and more here: 3e-5 of it.
                ASSERT_LT(glm::length(glm::cross(ray_of(*tile, place), *ray)), 6e-8) << optics.name;
                const glm::dvec2 inside =
                    glm::min(place - glm::dvec2(tile->x, tile->y),
                             glm::dvec2(tile->x + tile->size.width - 1, tile->y + tile->size.height - 1) - place);
                const glm::dvec4 reach = 0.5 * glm::abs(glm::dvec4(plan->footprint[i]));
                ASSERT_GE(inside.x, 2.0 + reach.x + reach.z) << optics.name;
                ASSERT_GE(inside.y, 2.0 + reach.y + reach.w) << optics.name;
            }
        }
    }
}

TEST(LensPlan, NoSideOfATexelIsLongerThanAPixel) {
    for (const Optics& optics : all_optics) {
        const auto plan = make_lens_plan(camera_of(optics), {}, {}).value();
        double longest = 0.0;
        for (std::size_t i = 0; i < plan.map.size(); ++i) {
            if (plan.map[i] == LensPlan::nowhere) continue;
            const glm::dvec4 step(plan.footprint[i]);
            const double area = std::abs(step.x * step.w - step.y * step.z);
            longest = std::max({longest, std::hypot(step.y, step.w) / area, std::hypot(step.x, step.z) / area});
        }
        EXPECT_LT(longest, 1.0 + 1e-5) << optics.name;
        EXPECT_GT(longest, 0.99) << optics.name << ": more texels than needed";
    }
}

TEST(LensPlan, TexelsLieOnPixelsAboutTheAxisOfABarrelLens) {
    const auto plan = make_lens_plan(camera_of(all_optics[1]), {}, {}).value();
    const std::size_t middle = 239 * 640 + 319;
    const glm::dvec2 place = place_of(plan, middle);
    EXPECT_NEAR(place.x, std::round(place.x), 0.01);
    EXPECT_NEAR(place.y, std::round(place.y), 0.01);
}

TEST(LensPlan, FacesThatNobodySeesAreNotThere) {
    Optics narrow{
        "narrow", {camera::LensModel::equidistant, {0, 0, 0, 0}}, {600, 600, 319.5, 239.5}, world::LensMethod::cube};
    EXPECT_EQ(make_lens_plan(camera_of(narrow), {.method = world::LensMethod::cube}, {})->tiles.size(), 1u);
    // 102 deg across and 76 down: left and right, nothing above and below.
    narrow.intrinsics = {360, 360, 319.5, 239.5};
    EXPECT_EQ(make_lens_plan(camera_of(narrow), {.method = world::LensMethod::cube}, {})->tiles.size(), 3u);
    EXPECT_EQ(make_lens_plan(camera_of(all_optics[6]), {}, {})->tiles.size(), 5u);
}

TEST(LensPlan, WhatTheDeviceCannotHoldIsAnErrorWithItsSize) {
    const auto plan = make_lens_plan(camera_of(all_optics[6]), {}, {.max_side = 512});
    ASSERT_FALSE(plan);
    EXPECT_EQ(plan.error().kind, ErrorKind::resource_exhausted);
    EXPECT_THAT(plan.error().message, testing::HasSubstr("at most 512 a side"));
    const auto large =
        camera::CameraModel::create({8192, 8192}, {4000, 4000, 4095.5, 4095.5}, all_optics[1].lens).value();
    EXPECT_FALSE(make_lens_plan(large, {}, {}));
}

}  // namespace
}  // namespace camrig::render
