#include "core/truth/make_truth.h"

#include <cmath>
#include <cstring>
#include <tuple>

#include <gtest/gtest.h>

namespace camrig::truth {
namespace {

constexpr ImageSize size{64, 48};

template <typename Value>
frame::FrameRef frame_of(const std::vector<Value>& values) {
    std::vector<std::byte> bytes(values.size() * sizeof(Value));
    std::memcpy(bytes.data(), values.data(), bytes.size());
    frame::FrameInfo info;
    info.size = size;
    return std::make_shared<frame::Frame>(info, std::move(bytes));
}

/// A triangle of 2 m, 5 m ahead of the origin along +x, with a nose in its middle.
world::ModelRef face() {
    auto model = std::make_shared<world::Model>();
    world::Primitive p;
    p.positions = {{0, -1, -1}, {0, 1, -1}, {0, 0, 1}};
    p.indices = {0, 1, 2};
    p.bounds = {{0, -1, -1}, {0, 1, 1}};
    model->meshes.push_back({.name = "", .primitives = {p}, .weights = {}});
    model->nodes.resize(1);
    model->nodes[0].mesh = 0;
    model->nodes[0].keypoint = "nose";
    // Undoes the turn from glTF's y up, so that the numbers above are the world's.
    model->nodes[0].local.rotation = glm::angleAxis(glm::radians(-90.0), glm::dvec3(1, 0, 0));
    model->order = {0};
    return model;
}

// -0.5 is in the picture, and belongs to column 0; the pixel before that in memory is the last one of the row above.
TEST(MakeTruth, APointOnTheLeftEdgeOfThePictureIsJudgedByTheFirstColumn) {
    auto info = std::make_shared<world::ObjectInfo>();
    info->id = ObjectId{7};
    info->name = "face";
    info->model = face();
    auto snapshot = std::make_shared<world::Snapshot>();
    snapshot->statics = std::make_shared<const world::StaticSet>();
    snapshot->movers.push_back({.info = info, .position = {5, 0, 0}, .clips = {}});

    auto spec = std::make_shared<world::CameraSpec>();
    spec->size = size;
    spec->intrinsics = {40.0, 40.0, -0.5, 5.0};
    std::vector<std::uint32_t> ids(64 * 48, 7u);
    std::vector<float> depths(64 * 48, 5.0f);
    ids[4 * 64 + 63] = 9u;  // something near covers the end of row 4
    depths[4 * 64 + 63] = 1.0f;
    const frame::FrameRef alone = frame_of(ids);
    const auto truth =
        make_truth({.name = std::make_shared<const std::string>("eye"), .spec = spec, .pose = {}}, *snapshot,
                   {.instance = alone, .depth = frame_of(depths)},
                   silhouettes_from([&](std::span<const ObjectId>) -> Result<frame::FrameRef> { return alone; }));
    ASSERT_TRUE(truth) << truth.error().message;
    ASSERT_EQ(truth->objects.size(), 1u);
    const Keypoint& nose = truth->objects[0].keypoints.at(0);
    EXPECT_EQ(nose.pixel, glm::dvec2(-0.5, 5.0));
    EXPECT_EQ(nose.visibility, KeypointVisibility::visible);
}

// Behind a fisheye depth along its axis falls with distance, and beside it it says nothing.
TEST(MakeTruth, BeyondARightAngleAPointIsHiddenByWhatIsNearer) {
    auto info = std::make_shared<world::ObjectInfo>();
    info->id = ObjectId{7};
    info->name = "face";
    info->model = face();
    auto spec = std::make_shared<world::CameraSpec>();
    spec->size = size;
    spec->intrinsics = {15.0, 15.0, 31.5, 23.0};
    spec->lens = {camera::LensModel::equidistant, {0.0, 0.0, 0.0, 0.0}};
    std::vector<std::uint32_t> shown(64 * 48, 9u);
    shown[0] = 7u;  // a corner of it
    const frame::FrameRef ids = frame_of(shown), alone = frame_of(std::vector<std::uint32_t>(64 * 48, 7u));
    for (const double column : {16.0, 8.0, 5.0}) {  // whose middles are 59, 89.8 and 101 deg aside
        const double angle = (31.5 - column) / 15.0;
        const glm::dvec3 to(std::cos(angle), std::sin(angle), 0.0);
        auto snapshot = std::make_shared<world::Snapshot>();
        snapshot->statics = std::make_shared<const world::StaticSet>();
        snapshot->movers.push_back({.info = info, .position = 5.0 * to, .clips = {}});
        for (const double shown_m : {2.0, 8.0}) {
            const std::vector<float> depths(64 * 48, static_cast<float>(shown_m * to.x));
            const auto truth = make_truth(
                {.name = std::make_shared<const std::string>("eye"), .spec = spec, .pose = {}}, *snapshot,
                {.instance = ids, .depth = frame_of(depths)},
                silhouettes_from([&](std::span<const ObjectId>) -> Result<frame::FrameRef> { return alone; }));
            ASSERT_TRUE(truth) << truth.error().message;
            ASSERT_EQ(truth->objects.size(), 1u);
            EXPECT_EQ(truth->objects[0].keypoints.at(0).visibility,
                      shown_m < 5.0 ? KeypointVisibility::occluded : KeypointVisibility::visible)
                << angle << " " << shown_m;
        }
    }
}

// What stands still is measured once for a camera that stands; never is anything of another pose or world told.
TEST(MakeTruth, WhatWasFoundOfStandingObjectsIsWhatIsFoundAnew) {
    const auto at = [](std::uint32_t id, glm::dvec3 position) {
        auto info = std::make_shared<world::ObjectInfo>();
        info->id = ObjectId{id};
        info->name = "face " + std::to_string(id);
        auto model = std::make_shared<world::Model>(*face());
        if (id != 2) model->nodes[0].keypoint = "";
        info->model = model;
        return world::Instance{.info = info, .position = position, .clips = {}};
    };
    const auto world = [&](double beside) {
        auto statics = std::make_shared<world::StaticSet>();
        statics->objects = {at(1, {6, beside, 0}), at(2, {8, 1, 0}), at(3, {-5, 0, 0})};
        return std::shared_ptr<const world::StaticSet>(statics);
    };
    auto spec = std::make_shared<world::CameraSpec>();
    spec->size = size;
    spec->intrinsics = {40.0, 40.0, 31.5, 23.5};
    auto wider = std::make_shared<world::CameraSpec>(*spec);
    wider->intrinsics.fx = 30.0;
    camera::Pose aside;
    aside.position.y = 0.5;
    const frame::FrameRef ids = frame_of(std::vector<std::uint32_t>(64 * 48, 0u));
    const auto silhouettes = [](std::span<const ObjectId> objects, std::span<const PixelBox>) {
        return Result<std::vector<frame::Silhouette>>(std::vector<frame::Silhouette>(objects.size(), {{3, 4, 9}}));
    };
    StandingObjects standing;
    const auto first = world(0.0), second = world(1.0);
    std::uint32_t n = 0;
    for (const auto& [statics, of, pose] :
         {std::tuple(first, spec, camera::Pose{}), std::tuple(first, spec, camera::Pose{}),
          std::tuple(first, spec, aside), std::tuple(first, wider, aside), std::tuple(second, wider, aside),
          std::tuple(second, wider, aside)}) {
        auto snapshot = std::make_shared<world::Snapshot>();
        snapshot->statics = statics;
        snapshot->movers = {at(9, {5.0 + 0.1 * n, 0, 0})};
        const frame::FrameRef depths = frame_of(std::vector<float>(64 * 48, n++ % 2 == 0 ? 100.0f : 1.0f));
        const TruthView view{.name = std::make_shared<const std::string>("eye"), .spec = of, .pose = pose};
        const auto kept = make_truth(view, *snapshot, {.instance = ids, .depth = depths}, silhouettes, &standing);
        const auto anew = make_truth(view, *snapshot, {.instance = ids, .depth = depths}, silhouettes);
        ASSERT_TRUE(kept && anew);
        ASSERT_EQ(kept->objects.size(), 3u);
        ASSERT_EQ(anew->objects.size(), 3u);
        for (std::size_t i = 0; i < 3; ++i) {
            const ObjectTruth &a = kept->objects[i], &b = anew->objects[i];
            EXPECT_EQ(a.id, b.id);
            EXPECT_EQ(a.pixels_alone, 5);
            EXPECT_EQ(a.box_full_min, b.box_full_min) << n;
            EXPECT_EQ(a.box_full_max, b.box_full_max) << n;
            EXPECT_EQ(a.center, b.center) << n;
            ASSERT_EQ(a.keypoints.size(), b.keypoints.size());
            for (std::size_t k = 0; k < a.keypoints.size(); ++k)
                EXPECT_EQ(a.keypoints[k].visibility, b.keypoints[k].visibility) << n;
        }
    }
}

// Its vertices belie its bounds: it is ahead of the camera, and would be found if they were looked at.
TEST(MakeTruth, TheVerticesOfWhatIsBehindTheCameraAreNotLookedAt) {
    const auto look = [](double place, float vertices) {
        auto model = std::make_shared<world::Model>(*face());
        for (glm::vec3& position : model->meshes[0].primitives[0].positions) position.x += vertices;
        auto info = std::make_shared<world::ObjectInfo>();
        info->id = ObjectId{7};
        info->name = "face";
        info->model = model;
        auto snapshot = std::make_shared<world::Snapshot>();
        snapshot->statics = std::make_shared<const world::StaticSet>();
        snapshot->movers.push_back({.info = info, .position = {place, 0, 0}, .clips = {}});
        auto spec = std::make_shared<world::CameraSpec>();
        spec->size = size;
        spec->intrinsics = {40.0, 40.0, 31.5, 23.5};
        const frame::FrameRef ids = frame_of(std::vector<std::uint32_t>(64 * 48, 7u));
        return make_truth({.name = std::make_shared<const std::string>("eye"), .spec = spec, .pose = {}}, *snapshot,
                          {.instance = ids, .depth = frame_of(std::vector<float>(64 * 48, 5.0f))},
                          silhouettes_from([&](std::span<const ObjectId>) -> Result<frame::FrameRef> { return ids; }));
    };
    const auto seen = look(5, 0), behind = look(-20, 25);
    ASSERT_TRUE(seen && behind);
    EXPECT_EQ(seen->objects.size(), 1U);
    EXPECT_TRUE(behind->objects.empty());
}

}  // namespace
}  // namespace camrig::truth
