#include "core/truth/truth_json.h"

#include <gtest/gtest.h>

namespace camrig::truth {
namespace {

TEST(TruthJson, HiddenObjectsHaveNoBoxAndUnknownPointsNoPlace) {
    TruthOfFrame truth;
    truth.camera = "lobby";
    truth.size = {640, 480};
    truth.classes = {{1, "building"}, {2, "person"}};
    ObjectTruth object;
    object.id = ObjectId{5};
    object.object_class = "person";
    object.pixels_alone = 40;
    object.box_full_min = {-3.5, 2.25};
    object.box_full_max = {6.5, 12.5};
    object.keypoints.resize(coco_keypoints.size());
    object.keypoints[9] = {.is_known = true,
                           .has_pixel = true,
                           .pixel = {4.5, 3.5},
                           .world = {1, 2, 3},
                           .visibility = KeypointVisibility::occluded};
    truth.objects = {object};
    const auto json = truth_to_json(truth);
    EXPECT_EQ(json["classes"], (nlohmann::json{{"building", 1}, {"person", 2}}));
    const auto& told = json["objects"][0];
    EXPECT_TRUE(told["box"].is_null());
    EXPECT_TRUE(told["occluded_by"].is_null());
    EXPECT_EQ(told["visible_fraction"], 0.0);
    EXPECT_EQ(told["box_full"], (nlohmann::json{-3.5, 2.25, 10.0, 10.25}));
    EXPECT_EQ(told["keypoints"].size(), 17u);
    EXPECT_EQ(told["keypoints"][9], (nlohmann::json{4.5, 3.5, 1}));
    EXPECT_EQ(told["keypoints_world"][9], (nlohmann::json{1.0, 2.0, 3.0}));
    EXPECT_TRUE(told["keypoints_world"][0].is_null());
}

TEST(TruthJson, ThingsWithoutKeypointsHaveNoSuchMembers) {
    TruthOfFrame truth;
    ObjectTruth object;
    object.pixels = object.pixels_alone = 4;
    object.box = PixelBox{1, 2, 3, 4};
    truth.objects = {object};
    const auto json = truth_to_json(truth);
    EXPECT_FALSE(json["objects"][0].contains("keypoints"));
    EXPECT_EQ(json["objects"][0]["box"], (nlohmann::json{1, 2, 3, 4}));
    EXPECT_EQ(json["objects"][0]["visible_fraction"], 1.0);
}

}  // namespace
}  // namespace camrig::truth
