#include <atomic>
#include <numbers>

#include <gmock/gmock.h>

#include "core/base/json_reader.h"
#include "core/photo/plate_json.h"
#include "core/photo/shadow_sun.h"
#include "tests/unit/control/rpc_harness.h"

namespace camrig::control {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::StartsWith;

constexpr double deg = std::numbers::pi / 180.0;

/// A camera that is known, and what it sees of some points.
struct KnownPlate {
    glm::dvec3 position{1.0, -2.0, 4.2};
    camera::PanTiltRoll angles{12 * deg, -17 * deg, 0.5 * deg};
    double focal = 1050.0;

    photo::PlateView view() const {
        photo::PlateView made;
        made.k = {focal, focal, 639.5, 359.5};
        made.lens = *camera::LensMap::create({});
        made.position = position;
        made.world_from_optical = camera::world_from_optical_rotation(*camera::pose_from_angles(position, angles));
        return made;
    }
    json task() const {
        json points = json::array();
        for (const glm::dvec3& m : {glm::dvec3(8, -3, 0), glm::dvec3(9, 3, 0), glm::dvec3(16, -4, 0),
                                    glm::dvec3(17, 5, 0), glm::dvec3(25, 2, 0), glm::dvec3(12, 1, 2.5)}) {
            const glm::dvec2 px = *view().project(m);
            points.push_back({{"px", {px.x, px.y}}, {"m", {m.x, m.y, m.z}}});
        }
        return {{"size", {1280, 720}}, {"points", points}, {"click_px", 0.5}};
    }
};

TEST(PlateMethods, CalibrateGivesTheKnownCameraBackAndTheVeryAnswerOfTheCommandLine) {
    RpcHarness rpc;
    const KnownPlate known;
    const json task = known.task(), found = rpc.result("plate.calibrate", task.dump());
    ASSERT_TRUE(found.contains("camera")) << found.dump();
    const json& camera = found["camera"];
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(camera["pose"]["position"][std::size_t(i)], known.position[i], 1e-4);
    EXPECT_NEAR(camera["pose"]["pan_deg"], 12, 1e-4);
    EXPECT_NEAR(camera["pose"]["tilt_deg"], -17, 1e-4);
    EXPECT_NEAR(camera["intrinsics"]["fx"], 1050, 1e-2);
    EXPECT_EQ(found["residuals"].size(), 6u);
    EXPECT_LT(found["rms_px"], 1e-3);
    EXPECT_EQ(found["verdict"], "good");
    JsonReader reader(task, "");
    const auto same = photo::calibrate_plate(photo::read_plate_task(reader, std::nullopt, std::nullopt));
    ASSERT_TRUE(same);
    EXPECT_EQ(found, photo::to_json(*same));
}

TEST(PlateMethods, WhatIsWrongWithATaskIsToldWithItsPlace) {
    const std::tuple<const char*, const char*, const char*> cases[] = {
        {"/size", "[8, 720]", "size: must be from 16x16"},
        {"/size", R"("large")", "size: "},
        {"/points/2/px", "[1]", "points[2].px: "},
        {"/points/2/m", "[1]", "points[2].m: "},
        {"/points/2/mm", "3", "points[2].mm: "},
        {"/points/1/px", "[2e6, 1]", "points[1].px: must be within 1e6 pixels"},
        {"/points/3/px", "[400, 20]", "points[3].px: is over the horizon"},
        {"/points/5/m", "[12, 1, 9]", "points[5]: is "},
        {"/points/1", R"({"px": [10, 10], "m": [8, -3, 0], "m2": 1})", "points[1].m2: "},
        {"/points", "[]", "points: none are given"},
        {"/heights", R"([{"foot_px": [10, 20], "head_px": [10, 5], "height_m": -1}])",
         "heights[0].height_m: must be over 0"},
        {"/lines", R"([{"axis": "w", "from_px": [1, 2], "to_px": [3, 9]}])", "lines[0].axis: must be x, y or z"},
        {"/lines", R"([{"axis": "z", "from_px": [1, 2], "to_px": [1, 2]}])", "lines[0].px: its ends"},
        {"/click_px", "0", "click_px: must be over 0"},
        {"/vfov_deg", "200", "vfov_deg: "},
        {"/camera_height_m", R"("high")", "camera_height_m: expected"},
        {"/lens", R"({"model": "glass", "coefficients": []})", "lens"},
    };
    for (const auto& [place, value, words] : cases) {
        RpcHarness rpc;
        json task = KnownPlate().task();
        task[json::json_pointer(place)] = json::parse(value);
        EXPECT_THAT(rpc.failure("plate.calibrate", task.dump()),
                    StartsWith(std::string("-32602 invalid_argument ") + words));
    }
}

TEST(PlateMethods, MoreThanCanBeSearchedIsRefused) {
    RpcHarness rpc;
    json task = KnownPlate().task();
    while (task["points"].size() <= photo::max_plate_points) task["points"].push_back(task["points"][0]);
    EXPECT_THAT(rpc.failure("plate.calibrate", task.dump()),
                StartsWith("-32000 resource_exhausted points: 257 items; at most 256"));
    task = KnownPlate().task();
    for (std::size_t n = 0; n <= photo::max_plate_heights; ++n)
        task["heights"].push_back({{"foot_px", {100, 500}}, {"head_px", {100, 400}}, {"height_m", 1.8}});
    EXPECT_THAT(rpc.failure("plate.calibrate", task.dump()), StartsWith("-32000 resource_exhausted heights: 25 items"));
    json asked{{"camera", {{"size", {64, 48}}, {"vfov_deg", 50}, {"pose", {{"position", {0, 0, 3}}}}}}};
    asked["pixels"] = json::array();
    while (asked["pixels"].size() <= 4096) asked["pixels"].push_back({1, 2});
    EXPECT_THAT(rpc.failure("plate.project", asked.dump()),
                StartsWith("-32000 resource_exhausted pixels: 4097 items; at most 4096"));
}

// A search takes long; nothing else waits for it, and no more of them than somebody chose wait for each other.
TEST(PlateMethods, SearchesWaitForEachOtherOnlyAndAreBounded) {
    RpcHarness rpc;
    std::atomic<int> answered{0}, refused{0};
    const json request{{"jsonrpc", "2.0"}, {"id", 1}, {"method", "plate.calibrate"}, {"params", KnownPlate().task()}};
    const int asked = 40;
    for (int n = 0; n < asked; ++n)
        rpc.server.handle(request.dump(), [&](RpcAnswer answer) {
            const std::string text = answer.joined();
            if (text.find("photos wait already; ask again later") != std::string::npos) ++refused;
            ++answered;
        });
    EXPECT_GT(refused.load(), 0);
    EXPECT_TRUE(rpc.result("world.status", "{}").contains("world_ns"));
    rpc.server.stop();
    EXPECT_EQ(answered.load(), asked) << "those that waited are told that the rig ends";
}

// Who only looks may not have a processor kept busy.
TEST(PlateMethods, WhoOnlyLooksMayNotSearch) {
    RpcHarness rpc;
    for (const char* method : {"plate.calibrate", "plate.project", "plate.light"}) {
        const json request{{"jsonrpc", "2.0"}, {"id", 1}, {"method", method}, {"params", KnownPlate().task()}};
        EXPECT_THAT(rpc.handle(request.dump(), Authority::look), HasSubstr("this is how to command")) << method;
    }
}

TEST(PlateMethods, ProjectIsTheLensOfTheCameraBothWays) {
    RpcHarness rpc;
    json asked{{"camera",
                {{"name", "other keys do not matter"},
                 {"size", {1280, 720}},
                 {"intrinsics", {{"fx", 700}, {"fy", 700}, {"cx", 639.5}, {"cy", 359.5}}},
                 {"lens", {{"model", "plumb_bob"}, {"coefficients", {-0.2, 0.03, 0, 0, 0}}}},
                 {"pose", {{"position", {0, 0, 4}}, {"tilt_deg", -25}}}}},
               {"points", {{6, 2, 0.5}, {-5, 0, 0}}},
               {"pixels", {{640, 10}}},
               {"z", 0.5}};
    const json first = rpc.result("plate.project", asked.dump());
    ASSERT_TRUE(first.contains("px")) << first.dump();
    EXPECT_TRUE(first["px"][1].is_null()) << "behind the camera";
    EXPECT_TRUE(first["m"][0].is_null()) << "over the horizon";
    // By hand: 6 m ahead, 2 m to the left, 3.5 m below, tilted down by 25 degrees.
    const double forth = 6 * std::cos(25 * deg) + 3.5 * std::sin(25 * deg),
                 down = 3.5 * std::cos(25 * deg) - 6 * std::sin(25 * deg);
    const double x = -2 / forth, y = down / forth, r2 = x * x + y * y, bend = 1 - 0.2 * r2 + 0.03 * r2 * r2;
    EXPECT_NEAR(first["px"][0][0], 700 * x * bend + 639.5, 1e-9);
    EXPECT_NEAR(first["px"][0][1], 700 * y * bend + 359.5, 1e-9);
    asked["pixels"] = json::array({first["px"][0]});
    const json back = rpc.result("plate.project", asked.dump());
    EXPECT_NEAR(back["m"][0][0], 6, 1e-6);
    EXPECT_NEAR(back["m"][0][1], 2, 1e-6);
    EXPECT_NEAR(back["m"][0][2], 0.5, 1e-9);
    asked["points"][1] = {1, 2};
    EXPECT_THAT(rpc.failure("plate.project", asked.dump()), StartsWith("-32602 invalid_argument points[1]: "));
    asked["camera"].erase("pose");
    EXPECT_THAT(rpc.failure("plate.project", asked.dump()),
                StartsWith("-32602 invalid_argument camera.pose: is missing"));
}

TEST(PlateMethods, LightComesFromAnglesFromATimeAtAPlaceAndFromAShadow) {
    RpcHarness rpc;
    const json by_angles = rpc.result("plate.light", R"({"sun": [150, 40]})");
    ASSERT_TRUE(by_angles.contains("lights")) << by_angles.dump();
    const json& sun = by_angles["lights"][0];
    // North is y, so that an azimuth of 150 degrees is 60 degrees to the right of x.
    const double across = std::cos(40 * deg);
    EXPECT_NEAR(sun["direction"][0], -across * std::cos(-60 * deg), 1e-9);
    EXPECT_NEAR(sun["direction"][1], -across * std::sin(-60 * deg), 1e-9);
    EXPECT_NEAR(sun["direction"][2], -std::sin(40 * deg), 1e-9);
    for (std::size_t i = 0; i < 3; ++i) {
        const double lit = sun["intensity"].get<double>() * sun["color"][i].get<double>() * std::sin(40 * deg) +
                           by_angles["environment"]["ambient"]["sky"][i].get<double>();
        EXPECT_NEAR(lit, 1.0, 1e-9) << "level ground in the sun has 1";
    }
    // Noon of midsummer in Berlin: in the south, 90 - 52.5 + 23.4 degrees up.
    const json by_time = rpc.result("plate.light", R"({"time": "2026-06-21T13:08:00+02:00", "place": [52.5, 13.4]})");
    EXPECT_NEAR(by_time["azimuth_deg"], 180, 0.5);
    EXPECT_NEAR(by_time["elevation_deg"], 60.94, 0.05);
    // A post of 2 m and its shadow by the sun above.
    const KnownPlate known;
    const glm::dvec3 direction{sun["direction"][0], sun["direction"][1], sun["direction"][2]}, foot(12, 1, 0),
        top(12, 1, 2);
    const glm::dvec3 tip = top - direction * (2.0 / direction.z);
    json asked{{"camera", photo::camera_json({1280, 720}, known.view().k, {}, photo::pose_of(known.view()))}};
    for (const auto& [key, m] : {std::pair("top_px", top), {"foot_px", foot}, {"tip_px", tip}}) {
        const glm::dvec2 px = *known.view().project(m);
        asked["shadow"][key] = {px.x, px.y};
    }
    const json by_shadow = rpc.result("plate.light", asked.dump());
    ASSERT_TRUE(by_shadow.contains("azimuth_deg")) << by_shadow.dump();
    EXPECT_NEAR(by_shadow["azimuth_deg"], 150, 1e-6);
    EXPECT_NEAR(by_shadow["elevation_deg"], 40, 1e-6);
    EXPECT_NEAR(by_shadow["shadow_of_m"], 2, 1e-9);
    asked.erase("camera");
    EXPECT_THAT(rpc.failure("plate.light", asked.dump()), StartsWith("-32602 invalid_argument camera: is missing"));
}

TEST(PlateMethods, WhatIsWrongWithALightIsToldWithItsPlace) {
    const std::pair<const char*, const char*> cases[] = {
        {"{}", "sun: give one of"},
        {R"({"sun": [1, 2], "time": "2026-06-21T13:08:00Z", "place": [1, 2]})", "sun: give one of"},
        {R"({"sun": [1]})", "sun: "},
        {R"({"sun": [150, 1]})", "sun: "},
        {R"({"time": "noon", "place": [1, 2]})", "time: "},
        {R"({"time": "2026-06-21T13:08:00Z"})", "place: is missing"},
        {R"({"place": [52, 13]})", "time: is missing"},
        {R"({"time": "2026-06-21T13:08:00Z", "place": [152, 13]})", "place: latitude"},
        {R"({"shadow": {"top_px": [1, 2], "foot_px": [1, 2]}})", "shadow.tip_px: is missing"},
    };
    for (const auto& [params, words] : cases) {
        RpcHarness rpc;
        EXPECT_THAT(rpc.failure("plate.light", params), StartsWith(std::string("-32602 invalid_argument ") + words))
            << params;
    }
}

}  // namespace
}  // namespace camrig::control
