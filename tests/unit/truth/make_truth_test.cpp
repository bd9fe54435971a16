#include "core/truth/make_truth.h"

#include <cstring>

#include <gtest/gtest.h>

namespace camrig {
namespace {

constexpr ImageSize size{64, 48};

template <typename Value>
FrameRef frame_of(const std::vector<Value>& values) {
    std::vector<std::byte> bytes(values.size() * sizeof(Value));
    std::memcpy(bytes.data(), values.data(), bytes.size());
    FrameInfo info;
    info.size = size;
    return std::make_shared<Frame>(info, std::move(bytes));
}

/// A triangle of 2 m, 5 m ahead of the origin along +x, with a nose in its middle.
ModelRef face() {
    auto model = std::make_shared<Model>();
    Primitive p;
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
    auto info = std::make_shared<ObjectInfo>();
    info->id = ObjectId{7};
    info->name = "face";
    info->model = face();
    auto snapshot = std::make_shared<Snapshot>();
    snapshot->statics = std::make_shared<const StaticSet>();
    snapshot->movers.push_back({.info = info, .position = {5, 0, 0}, .clips = {}});

    auto spec = std::make_shared<CameraSpec>();
    spec->size = size;
    spec->intrinsics = {40.0, 40.0, -0.5, 5.0};
    std::vector<std::uint32_t> ids(64 * 48, 7u);
    std::vector<float> depths(64 * 48, 5.0f);
    ids[4 * 64 + 63] = 9u;  // something near covers the end of row 4
    depths[4 * 64 + 63] = 1.0f;
    const FrameRef alone = frame_of(ids);
    const auto truth = make_truth({.name = std::make_shared<const std::string>("eye"), .spec = spec, .pose = {}},
                                  *snapshot, {.instance = alone, .depth = frame_of(depths)},
                                  [&](std::span<const ObjectId>) -> Result<FrameRef> { return alone; });
    ASSERT_TRUE(truth) << truth.error().message;
    ASSERT_EQ(truth->objects.size(), 1u);
    const Keypoint& nose = truth->objects[0].keypoints.at(0);
    EXPECT_EQ(nose.pixel, glm::dvec2(-0.5, 5.0));
    EXPECT_EQ(nose.visibility, KeypointVisibility::visible);
}

}  // namespace
}  // namespace camrig
