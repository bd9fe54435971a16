#include <cmath>
#include <fstream>
#include <iostream>
#include <map>

#include <gtest/gtest.h>

#include "core/world/walk/walk_area.h"
#include "core/world/world.h"
#include "tests/unit/world/crowd_watch.h"
#include "tests/unit/world/world_fixture.h"

// Nobody walks through a wall or through somebody else.
namespace camrig::world::crowd_test {
namespace {

using namespace world_test;

TEST(CrowdOfHundred, WalksInASquareForTenMinutesAndNobodyThroughAnother) {
    auto scene = empty_scene(40 * ns_per_ms);
    Area& square = scene->areas["square"];
    // Between the places where they begin.
    square.obstacles = {{{9, 9}, {10.1, 9}, {10.1, 10.1}, {9, 10.1}},
                        {{3.3, 14.7}, {4.4, 14.7}, {4.4, 15.8}, {3.3, 15.8}}};
    for (int i = 0; i < 100; ++i) {
        ActorSpec person = actor(R"({"name": "p", "model": "man", "class": "person", "behaviour":
            {"type": "wander", "area": "square", "clip": "walk", "idle_clip": "wait", "pause_s": 2}})");
        person.name = "p" + std::to_string(i);
        person.position = {1.0 + 1.9 * (i % 10), 1.0 + 1.9 * (i / 10), 0.0};
        scene->actors.push_back(person);
    }
    auto world = World::create(scene, 1).value();
    const Depths depths = watch(*world, square, 600 * ns_per_s);
    std::cout << "deepest: bodies " << depths.bodies_m << " m (" << depths.worst << "), walls " << depths.walls_m
              << " m; walked " << depths.walked_m << " m\n";
    // Discs of 0.28 m, arms included; in a jam, where nothing avoids all, they may touch by some of that.
    EXPECT_LT(depths.bodies_m, 0.06);
    EXPECT_LT(depths.walls_m, 0.01);
    EXPECT_GT(depths.walked_m, 100 * 600 * 0.4);
}

TEST(Hall, NobodyWalksThroughSomebodyOrSomethingInTenMinutes) {
    const auto scene = load_scene("scenes/hall.json");
    ASSERT_TRUE(scene) << scene.error().message;
    // The whole ground floor with all that stands on it, whatever the scene's own areas are.
    std::ifstream file("scenes/hall/plan.json");
    const auto plan = nlohmann::json::parse(file);
    Area floor;
    floor.points = {{0.0, 0.0}, {30.2, 0.0}, {30.2, 20.0}, {0.0, 20.0}};
    for (const auto& [name, r] : plan["obstacles"].items()) {
        const double x0 = r[0], y0 = r[1], x1 = r[2], y1 = r[3];
        // Noah sits on a bench; the footprint of its seat is where he is.
        if (name != "benches_near") floor.obstacles.push_back({{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}});
    }
    auto world = World::create(*scene, (*scene)->seed).value();
    const Depths depths = watch(*world, floor, 600 * ns_per_s);
    std::cout << "deepest: bodies " << depths.bodies_m << " m (" << depths.worst << "), walls " << depths.walls_m
              << " m; walked " << depths.walked_m << " m\n";
    EXPECT_LT(depths.bodies_m, 0.02);
    EXPECT_LT(depths.walls_m, 0.02);
    std::map<std::string, int> fired;
    for (const EventReport& event : world->events()) fired[event.name] = static_cast<int>(event.fired);
    EXPECT_EQ(fired["bag_abandoned"], 5);
    EXPECT_GE(fired["somebody_goes"], 30);
    for (const EventRecord& record : world->take_records())
        for (const std::string& problem : record.errors) ADD_FAILURE() << record.event << ": " << problem;
}

}  // namespace
}  // namespace camrig::world::crowd_test
