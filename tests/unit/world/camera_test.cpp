#include "core/world/camera.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/world/mount.h"
#include "tests/unit/world/world_fixture.h"

namespace camrig::world::camera_test {
namespace {

using namespace world_test;

Camera camera_at(const camera::Pose& pose, std::optional<Mount> mount = {}) {
    CameraPatch patch;
    patch.pose = pose;
    patch.mount = std::move(mount);
    return Camera().changed(patch, 0, 0).value();
}

Snapshot time(TimeNs world_ns) {
    return {.world_ns = world_ns, .statics = {}, .movers = {}};
}

CameraPatch zoom(double factor) {
    CameraPatch patch;
    patch.zoom = factor;
    return patch;
}

TEST(Camera, ZoomsAndTurnsEachInItsOwnTime) {
    Camera camera = camera_at({});
    const double fx = camera.spec()->intrinsics.fx;
    camera = camera.changed(zoom(4), ns_per_s, 2 * ns_per_s).value();
    CameraPatch turn;
    turn.pan_rad = 1.0;
    camera = camera.changed(turn, 2 * ns_per_s, 4 * ns_per_s).value();
    EXPECT_EQ(camera.arrives_ns(), 6 * ns_per_s);
    EXPECT_EQ(camera.at(time(ns_per_s)).intrinsics.fx, fx);
    EXPECT_NEAR(camera.at(time(2 * ns_per_s)).intrinsics.fx, 2 * fx, 1e-9);
    EXPECT_EQ(camera.at(time(3 * ns_per_s)).intrinsics, camera.spec()->intrinsics);
    EXPECT_NEAR(camera::angles_of(camera.at(time(4 * ns_per_s)).pose.orientation).pan, 0.5, 1e-12);
    EXPECT_EQ(camera.at(time(6 * ns_per_s)).pose, camera.spec()->pose);
}

TEST(Camera, AHeadTurnsFromWhereItIsNotFromWhereItWasSent) {
    CameraPatch drive;
    drive.pose = camera::Pose{{10, 0, 0}};
    Camera camera = camera_at({}).changed(drive, 0, 10 * ns_per_s).value();
    CameraPatch turn;
    turn.pan_rad = 1.0;
    camera = camera.changed(turn, 5 * ns_per_s, 0).value();
    EXPECT_EQ(camera.at(time(9 * ns_per_s)).pose.position, glm::dvec3(5, 0, 0));
}

TEST(Camera, OpticsOfAnotherSizeOrPrincipalPointAreThereAtOnce) {
    Camera camera = camera_at({}).changed(zoom(4), 0, ns_per_s).value();
    CameraPatch larger;
    larger.size = ImageSize{1280, 960};
    EXPECT_EQ(camera.changed(larger, ns_per_s / 2, ns_per_s)->at(time(ns_per_s / 2)).intrinsics.cx, 639.5);
    CameraPatch shifted;
    shifted.optics = camera::Intrinsics{500, 500, 300, 200};
    EXPECT_EQ(camera.changed(shifted, ns_per_s / 2, ns_per_s)->at(time(ns_per_s / 2)).intrinsics,
              (camera::Intrinsics{500, 500, 300, 200}));
}

TEST(Camera, WhatIsToldOfAMovingCameraMakesOneThatIsThere) {
    CameraPatch change = zoom(2);
    change.pose = camera::Pose{{4, 0, 0}};
    const Camera camera = camera_at({}).changed(change, 0, 4 * ns_per_s).value();
    const CameraSpec there = camera.spec_at(ns_per_s);
    EXPECT_EQ(there.pose.position, glm::dvec3(1, 0, 0));
    EXPECT_EQ(there.intrinsics, camera.at(time(ns_per_s)).intrinsics);
    EXPECT_EQ(there.name, camera.spec()->name);
}

/// A camera on an actor that walks, goes, and comes again, while its own head turns: what it is at a time does not
/// depend on when, how often and in which order it was asked.
TEST(Camera, OnAnActorThatGoesIsTheSameInWhateverOrderItIsAsked) {
    auto scene = empty_scene(10 * ns_per_ms);
    scene->events = {
        event(
            R"({"name": "come", "when": {"at_s": 0.2}, "do": [{"action": "spawn", "actor": {"name": "c", "model": "man",
                  "behaviour": {"type": "route", "route": "line", "clip": "walk"}}}]})"),
        event(R"({"name": "go", "when": {"at_s": 0.65}, "do": [{"action": "remove", "actor": "c"}]})"),
        event(
            R"({"name": "again", "when": {"at_s": 0.8}, "do": [{"action": "spawn", "actor": {"name": "c", "model": "man",
                  "position": [1, 2, 0]}}]})"),
        event(R"({"name": "gone", "when": {"at_s": 0.9}, "do": [{"action": "remove", "actor": "c"}]})")};
    const auto world = World::create(scene, 3).value();
    CameraPatch turn;
    turn.tilt_rad = 1.0;
    Camera camera = camera_at({{0, 0, 2}}, Mount{"c", ""}).changed(turn, 0, ns_per_s).value();
    std::vector<camera::CameraState> seen;
    for (std::uint64_t i = 0; i < 400; ++i) {
        const TimeNs now_ns = static_cast<TimeNs>(i) * 2'999'999;
        world->advance_to(now_ns);
        for (const Departure& departure : world->take_departures())
            if (departure.instance.info->name == "c") camera.leave(departure.instance, departure.world_ns);
        seen.push_back(camera.at(*world->snapshot(now_ns)));
        for (std::uint64_t k = 0; k < 5; ++k) {
            const camera::CameraState& one = seen[random_bits(1, i, k) % seen.size()];
            if (one.world_ns < world->last_step_ns() - camera::Timeline<camera::Pose>::kept_ns) continue;
            ASSERT_EQ(camera.at(*world->snapshot(one.world_ns)), one) << one.world_ns << " at " << now_ns;
        }
    }
    const auto x_at = [&](TimeNs world_ns) {
        return seen[static_cast<std::size_t>(world_ns / 2'999'999)].pose.position.x;
    };
    EXPECT_EQ(x_at(100 * ns_per_ms), 0.0) << "before its actor is there, the frame is the world's";
    EXPECT_GT(x_at(600 * ns_per_ms), 0.2);
    EXPECT_NEAR(x_at(700 * ns_per_ms), 0.45 * walk_ground_m_s, 0.05) << "it stays where its actor went";
    EXPECT_EQ(x_at(850 * ns_per_ms), 1.0);
    EXPECT_EQ(x_at(1100 * ns_per_ms), 1.0);
}

TEST(Camera, OnAnotherMountOrHeadItsPastStaysWhatItWas) {
    const auto world = World::create(empty_scene(10 * ns_per_ms), 3).value();
    ASSERT_TRUE(world->spawn_actor(actor(R"({"name": "c", "model": "man", "position": [3, 4, 0]})")));
    ASSERT_TRUE(world->spawn_actor(actor(R"({"name": "d", "model": "man", "position": [7, 8, 0]})")));
    Camera camera = camera_at({{0, 0, 2}}, Mount{"c", ""});
    const auto x_at = [&](TimeNs world_ns) { return camera.at(*world->snapshot(world_ns)).pose.position.x; };
    CameraPatch other;
    other.mount = Mount{"d", ""};
    other.pose = camera::Pose{{0, 0, 1}};
    other.change([](CameraSpec& spec) { spec.ptz = camera::ptz_preset(camera::PtzPreset::ideal); });
    world->advance_to(200 * ns_per_ms);
    camera = camera.changed(other, 150 * ns_per_ms, ns_per_s).value();
    EXPECT_EQ(x_at(150 * ns_per_ms - 1), 3.0);
    EXPECT_EQ(x_at(150 * ns_per_ms), 7.0);
    camera = camera.with_head([](camera::PtzHead& head) { return head.move({.zoom = 2.0}, 160 * ns_per_ms); }).value();
    world->advance_to(200 * ns_per_ms);
    const auto fx_at = [&](TimeNs world_ns) { return camera.at(*world->snapshot(world_ns)).intrinsics.fx; };
    ASSERT_GT(fx_at(200 * ns_per_ms), camera.spec()->intrinsics.fx);
    CameraPatch none;
    none.change([](CameraSpec& spec) { spec.ptz = {}; });
    const double zoomed = fx_at(190 * ns_per_ms);
    camera = camera.changed(none, 195 * ns_per_ms, 0).value();
    EXPECT_EQ(fx_at(190 * ns_per_ms), zoomed);
    EXPECT_EQ(fx_at(195 * ns_per_ms), camera.spec()->intrinsics.fx);
    EXPECT_EQ(x_at(10 * ns_per_ms), 3.0);
}

TEST(Camera, LookingStraightDownIsNotPastItHoweverInexactTheHead) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        CameraPatch patch;
        patch.change([&](CameraSpec& spec) {
            spec.ptz = camera::ptz_preset(camera::PtzPreset::dome);
            spec.ptz->tilt_limits_deg = {-180.0, 0.0};
            spec.ptz->repeatability_deg = 0.05;
            spec.ptz->seed = seed;
        });
        Camera camera = Camera().changed(patch, 0, 0).value();
        camera = camera.with_head([](camera::PtzHead& head) { return head.move({.tilt_deg = -90.0}, 0); }).value();
        const camera::Pose pose = camera.at(time(60 * ns_per_s)).pose;
        EXPECT_GT((pose.orientation * glm::dvec3(0, 0, 1)).x, 0.9) << "the upper edge of the picture is ahead";
    }
}

TEST(Camera, WhereItsHeadHasFlippedTiltIsAsThePictureShowsIt) {
    for (const bool flips : {true, false}) {
        CameraPatch patch;
        patch.tilt_rad = -0.5;
        patch.change([&](CameraSpec& spec) {
            spec.ptz = camera::ptz_preset(camera::PtzPreset::ideal);
            spec.ptz->flips = flips;
        });
        Camera camera = Camera().changed(patch, 0, 0).value();
        const auto tell = [&](const camera::PtzMove& move, TimeNs when) {
            camera =
                camera.with_head([&](camera::PtzHead& head) { return head.move(*camera.in_angles(move, when), when); })
                    .value();
        };
        const auto height = [&](TimeNs when) {
            return (camera.at(time(when)).pose.orientation * glm::dvec3(1, 0, 0)).z;
        };
        tell({.tilt_deg = -90.0}, 0);
        EXPECT_EQ((camera.at(time(ns_per_s)).pose.orientation * glm::dvec3(0, 0, 1)).z > 0.0, flips);
        const double over = height(ns_per_s);
        tell({.mode = camera::PtzMode::relative, .tilt_deg = 5.0}, ns_per_s);
        EXPECT_EQ(height(2 * ns_per_s) > over, false) << "there is no way on: it is at its limit";
        tell({.tilt_deg = -80.0}, 2 * ns_per_s);
        const double before = height(3 * ns_per_s);
        tell({.mode = camera::PtzMode::continuous, .tilt_deg = 2.0, .timeout = ns_per_s}, 3 * ns_per_s);
        EXPECT_EQ(height(5 * ns_per_s) > before, flips);
        tell({.tilt_deg = -10.0}, 5 * ns_per_s);
        const double upright = height(6 * ns_per_s);
        tell({.mode = camera::PtzMode::relative, .tilt_deg = 5.0}, 6 * ns_per_s);
        EXPECT_GT(height(7 * ns_per_s), upright);
    }
}

TEST(Camera, InAnotherWorldItHasArrivedAndStaysWhereItsActorWas) {
    const auto world = World::create(empty_scene(), 3).value();
    ASSERT_TRUE(world->spawn_actor(actor(R"({"name": "c", "model": "man", "position": [3, 4, 0]})")));
    const Camera camera = camera_at({{0, 0, 2}}, Mount{"c", ""}).changed(zoom(3), 0, ns_per_s).value();
    const Camera next = camera.in_another_world(*world->snapshot(0));
    EXPECT_EQ(next.at(time(0)).pose.position, glm::dvec3(3, 4, 2));
    EXPECT_EQ(next.at(time(0)).intrinsics, camera.spec()->intrinsics);
    EXPECT_EQ(next.arrives_ns(), 0);
}

}  // namespace
}  // namespace camrig::world::camera_test
