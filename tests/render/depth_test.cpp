#include <algorithm>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "tests/render/support/test_rig.h"

namespace camrig::render {
namespace {

world::Instance wall_at(double x, glm::vec3 color, std::uint32_t id) {
    // Large enough to fill the picture at any distance; its place is in the instance, in double.
    const auto half = static_cast<float>(2.0 * x);
    return instance_of(model_of(rectangle({0, 0, 0}, {0, -half, 0}, {0, 0, half}), colored(color, true)), {x, 0, 0},
                       id);
}

std::vector<float> floats_of(const frame::FrameRef& frame) {
    std::vector<float> values(frame->bytes().size() / sizeof(float));
    std::memcpy(values.data(), frame->bytes().data(), frame->bytes().size());
    return values;
}

TEST(Depth, NearerCoversFartherAtAMetreAndAtTenKilometresInAnyOrder) {
    for (const double z : {1.0, 10'000.0}) {
        for (const bool near_first : {true, false}) {
            TestWorld world;
            world.objects = {wall_at(z, {1, 0, 0}, 1), wall_at(z * 1.001, {0, 1, 0}, 2)};
            if (!near_first) std::swap(world.objects[0], world.objects[1]);
            EXPECT_EQ(draw(world, {}).at(20, 20), (std::array{255, 0, 0, 255})) << z;
        }
    }
}

TEST(Depth, PlanesAMillionthOfTheirDistanceApartAreOrderedFromAMetreToAThousandKilometres) {
    for (double z = 1.0; z <= 1e6; z *= 10.0) {
        TestWorld world;
        world.objects = {wall_at(z * (1.0 + 1e-6), {0, 1, 0}, 2), wall_at(z, {1, 0, 0}, 1)};
        const Picture picture = draw(world, {});
        for (int y = 0; y < 48; ++y) {
            for (int x = 0; x < 64; ++x) ASSERT_EQ(picture.red(x, y), 255) << z << " at " << x << "," << y;
        }
    }
}

TEST(Depth, DepthFramesHoldMetresAlongTheOpticalAxis) {
    for (const double far_m : {0.0, 5e7}) {
        for (double z = 0.1; z < 1e7; z *= 7.3) {
            TestWorld world;
            world.objects = {wall_at(z, {1, 1, 1}, 1)};
            for (const float value : floats_of(draw_kind(world, {.far_m = far_m}, frame::FrameKind::depth))) {
                ASSERT_NEAR(value / z, 1.0, 1e-6) << z << " far " << far_m;
            }
        }
    }
}

TEST(Depth, NothingIsInfinitelyFar) {
    for (const float value : floats_of(draw_kind({}, {}, frame::FrameKind::depth))) ASSERT_TRUE(std::isinf(value));
}

TEST(Depth, DepthOfASlantedPlaneIsAnalytic) {
    // Floor 1 m below the camera: depth of row v is fy / (v - cy).
    TestWorld world;
    world.objects = {instance_of(model_of(rectangle({0, 0, -1}, {500, 0, 0}, {0, 500, 0}), colored({1, 1, 1})))};
    const auto depth = floats_of(draw_kind(world, {.size = {65, 49}}, frame::FrameKind::depth));
    for (int y = 30; y < 49; ++y) {
        EXPECT_NEAR(depth[static_cast<std::size_t>(y) * 65 + 20] / (64.0 / (y - 24)), 1.0, 1e-5) << y;
    }
}

TEST(Truth, InstanceFramesCarryObjectNumbersAndZeroForNothing) {
    TestWorld world;
    world.objects = {instance_of(model_of(box(glm::vec3(0.5f)), colored({1, 1, 1})), {5, 0, 0}, 4711)};
    world.movers = {instance_of(model_of(box(glm::vec3(0.5f)), colored({1, 1, 1})), {4, -1, 0}, 0x80000001u)};
    const frame::FrameRef frame = draw_kind(world, {.size = {65, 49}}, frame::FrameKind::instance);
    std::vector<std::uint32_t> ids(65 * 49);
    std::memcpy(ids.data(), frame->bytes().data(), frame->bytes().size());
    EXPECT_EQ(ids[24 * 65 + 32], 4711u);
    EXPECT_EQ(ids[24 * 65 + 50], 0x80000001u);
    EXPECT_EQ(ids[2 * 65 + 2], 0u);
}

TEST(Truth, SemanticFramesCarryClassNumbers) {
    TestWorld world;
    world.objects = {instance_of(model_of(box(glm::vec3(0.5f)), colored({1, 1, 1})), {5, 0, 0}, 4711)};
    auto info = std::make_shared<world::ObjectInfo>(*world.objects[0].info);
    info->class_number = 3;
    world.objects[0].info = info;
    const frame::FrameRef frame = draw_kind(world, {.size = {65, 49}}, frame::FrameKind::semantic);
    std::vector<std::uint32_t> classes(65 * 49);
    std::memcpy(classes.data(), frame->bytes().data(), frame->bytes().size());
    EXPECT_EQ(classes[24 * 65 + 32], 3u);
    EXPECT_EQ(classes[2 * 65 + 2], 0u);
}

TEST(Truth, AnObjectAloneShowsWhatOthersHide) {
    TestWorld world;
    world.objects = {wall_at(4.0, {1, 0, 0}, 1), wall_at(8.0, {0, 1, 0}, 2)};
    View view = TestCamera{}.view();
    std::ranges::fill(view.kinds, false);
    view.kinds[static_cast<int>(frame::FrameKind::instance)] = true;
    for (const std::uint32_t id : {1u, 2u}) {
        view.only_objects = {ObjectId{id}};
        const frame::FrameRef frame = draw_views(world.snapshot(), {&view, 1}).at(0);
        std::vector<std::uint32_t> ids(64 * 48);
        std::memcpy(ids.data(), frame->bytes().data(), frame->bytes().size());
        EXPECT_EQ(std::ranges::count(ids, id), 64 * 48);
    }
}

TEST(Truth, NormalFramesAreUnitVectorsOfTheOpticalFrame) {
    TestWorld world;
    world.objects = {instance_of(model_of(rectangle({2, 0, 0}, {0, -4, 0}, {0, 0, 4}), colored({1, 1, 1})))};
    const auto normals = floats_of(draw_kind(world, {.size = {65, 49}}, frame::FrameKind::normal));
    const std::size_t middle = 3 * (24 * 65 + 32);
    EXPECT_NEAR(normals[middle], 0.0f, 1e-6);
    EXPECT_NEAR(normals[middle + 1], 0.0f, 1e-6);
    EXPECT_NEAR(normals[middle + 2], -1.0f, 1e-6);
}

TEST(Truth, MaskedHolesAreSeenThrough) {
    auto model = model_of(rectangle({2, 0, 0}, {0, -4, 0}, {0, 0, 4}), colored({1, 1, 1}));
    model->materials[0].alpha_mode = world::AlphaMode::mask;
    model->materials[0].base_color.a = 0.4f;
    TestWorld world;
    world.objects = {instance_of(model)};
    for (const float value : floats_of(draw_kind(world, {}, frame::FrameKind::depth))) ASSERT_TRUE(std::isinf(value));
    EXPECT_EQ(draw(world, {}).red(10, 10), 0);
}

}  // namespace
}  // namespace camrig::render
