#include "tools/view/arrangement.h"

#include <gtest/gtest.h>

namespace camrig::view {
namespace {

using nlohmann::json;

TEST(Arrangement, HoldsWhatMakesACameraAndNotTheViewsOwn) {
    const json list = json::parse(R"({"cameras": [
        {"name": "lobby", "fps": "30000/1001", "id": 3, "sequence": 9, "readers": 1, "applied_ns": 5, "vfov_deg": 60, "hfov_deg": 75,
         "intrinsics": {"fx": 1, "fy": 1, "cx": 0, "cy": 0}, "world_pose": {}, "mount": null,
         "pose": {"position": [1, 2, 3], "orientation": [0, 0, 0, 1], "pan_deg": 0, "tilt_deg": 0, "roll_deg": 0}},
        {"name": "view_77"}]})");
    EXPECT_EQ(arrangement_of(list, "view_77"), json::parse(R"({"cameras": [
        {"name": "lobby", "fps": "30000/1001", "intrinsics": {"fx": 1, "fy": 1, "cx": 0, "cy": 0}, "mount": null,
         "pose": {"position": [1, 2, 3], "pan_deg": 0, "tilt_deg": 0, "roll_deg": 0}}]})"));
}

TEST(FreeName, CountsOnAndStaysShortEnough) {
    EXPECT_EQ(free_name("lobby", {"lobby"}), "lobby_2");
    EXPECT_EQ(free_name("lobby_2", {"lobby", "lobby_2"}), "lobby_3");
    EXPECT_EQ(free_name("lobby_9", {"lobby_9"}), "lobby_2");
    EXPECT_EQ(free_name("cam_a", {}), "cam_a_2");
    EXPECT_EQ(free_name("abcdefghijklmnopqrstuvwx", {}), "abcdefghijklmnopqrstuv_2");
}

}  // namespace
}  // namespace camrig::view
