#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/world/world.h"
#include "tests/unit/world/world_fixture.h"

namespace camrig::world::objects_test {
namespace {

using namespace world_test;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* anna = R"({"name": "anna", "model": "man", "class": "person", "position": [2, 2, 0],
    "behaviour": {"type": "go_to", "position": [12, 2, 0], "area": "square", "clip": "walk"}})";

ObjectSpec object(const std::string& name) {
    ObjectSpec spec;
    spec.name = name;
    spec.model = "man";
    return spec;
}

ObjectReport report(const World& world, const std::string& name) {
    ObjectReport told;
    EXPECT_NE(find_object(*world.snapshot(world.last_step_ns()), name, &told), nullptr) << name;
    return told;
}

std::vector<std::string> names(const std::vector<Instance>& instances) {
    std::vector<std::string> all;
    for (const Instance& one : instances) all.push_back(one.info->name);
    return all;
}

TEST(Objects, SpawnedAndRemovedOnesShowFromTheirStepOn) {
    auto world = World::create(empty_scene(), 1).value();
    world->advance_to(100 * ns_per_ms);
    const std::size_t before = world->object_count();
    ASSERT_TRUE(world->spawn_object(object("vase")));
    EXPECT_EQ(world->object_count(), before + 1);
    EXPECT_EQ(find_object(*world->snapshot(95 * ns_per_ms), "vase"), nullptr);
    EXPECT_FALSE(report(*world, "vase").moves);
    EXPECT_EQ(report(*world, "vase").model, "man");
    EXPECT_EQ(world->spawn_object(object("vase")).error().kind, ErrorKind::already_exists);
    ObjectSpec unknown = object("x");
    unknown.model = "nothing";
    EXPECT_THAT(world->spawn_object(unknown).error().message, HasSubstr("nothing"));
    ASSERT_TRUE(world->remove_object("vase"));
    EXPECT_EQ(find_object(*world->snapshot(100 * ns_per_ms), "vase"), nullptr);
    EXPECT_EQ(world->remove_object("vase").error().kind, ErrorKind::not_found);
}

TEST(Objects, HiddenOnesAreKeptApartAndComeBackInTheirPlace) {
    auto world = World::create(empty_scene(), 1).value();
    for (const char* name : {"a", "b", "c"}) ASSERT_TRUE(world->spawn_object(object(name)));
    const auto first = names(world->snapshot(0)->statics->objects);
    ASSERT_TRUE(world->change_object({.name = "b", .hidden = true}));
    const SnapshotRef without = world->snapshot(0);
    EXPECT_THAT(names(without->statics->hidden), ElementsAre("b"));
    EXPECT_EQ(without->statics->objects.size() + 1, first.size());
    EXPECT_TRUE(report(*world, "b").hidden);
    EXPECT_EQ(objects_of(*without).size(), first.size());
    // Its name is taken all the same, and it can be changed while nobody sees it.
    EXPECT_EQ(world->spawn_object(object("b")).error().kind, ErrorKind::already_exists);
    ASSERT_TRUE(world->change_object({.name = "b", .scale = 2.0, .position = glm::dvec3(1, 2, 3)}));
    ASSERT_TRUE(world->change_object({.name = "b", .hidden = false}));
    EXPECT_EQ(names(world->snapshot(0)->statics->objects), first);
    EXPECT_EQ(report(*world, "b").scale, 2.0);
    EXPECT_EQ(report(*world, "b").position, glm::dvec3(1, 2, 3));
}

TEST(Objects, AHiddenActorGoesItsWayAsItWouldAnyhow) {
    const auto place_after = [](bool hides) {
        auto scene = empty_scene();
        scene->actors = {actor(anna)};
        auto world = World::create(scene, 1).value();
        world->advance_to(ns_per_s);
        if (hides) {
            EXPECT_TRUE(world->change_object({.name = "anna", .hidden = true}));
        }
        EXPECT_EQ(world->snapshot(ns_per_s - 5 * ns_per_ms)->movers.size(), 1u);  // it was there before
        world->advance_to(2 * ns_per_s);
        const SnapshotRef between = world->snapshot(2 * ns_per_s - 5 * ns_per_ms);
        EXPECT_EQ(between->movers.size(), hides ? 0u : 1u);
        EXPECT_EQ(between->hidden.size(), hides ? 1u : 0u);
        if (hides) {
            EXPECT_TRUE(world->change_object({.name = "anna", .hidden = false}));
            EXPECT_EQ(world->snapshot(2 * ns_per_s)->movers.size(), 1u);
        }
        return report(*world, "anna").position;
    };
    EXPECT_EQ(place_after(true), place_after(false));
}

TEST(Objects, ActorsAreScaledHereAndPlacedByActorSet) {
    auto scene = empty_scene();
    scene->actors = {actor(anna)};
    auto world = World::create(scene, 1).value();
    ASSERT_TRUE(world->change_object({.name = "anna", .scale = 0.5}));
    EXPECT_EQ(report(*world, "anna").scale, 0.5);
    EXPECT_TRUE(report(*world, "anna").moves);
    EXPECT_THAT(world->change_object({.name = "anna", .position = glm::dvec3(0.0)}).error().message,
                HasSubstr("position: 'anna' is an actor; actor.set"));
    EXPECT_THAT(world->remove_object("anna").error().message, HasSubstr("actor.remove"));
    EXPECT_EQ(world->change_object({.name = "nobody", .hidden = true}).error().kind, ErrorKind::not_found);
}

TEST(Objects, ActorsKeepToWhatTheyDoWhenTheyAreScaled) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man",
                               "behaviour": {"type": "route", "route": "line", "speed": 1, "clip": "walk"}})"),
                     actor(R"({"name": "ben", "model": "man", "position": [2, 2, 0]})")};
    auto world = World::create(scene, 1).value();
    const SteerSpec go[] = {{.name = "ben", .velocity = glm::dvec3(1, 0, 0), .clip = "walk"}};
    ASSERT_TRUE(world->steer_actors(go));
    world->advance_to(5 * ns_per_s);
    for (const char* name : {"anna", "ben"}) ASSERT_TRUE(world->change_object({.name = name, .scale = 1.5}));
    world->advance_to(6 * ns_per_s);
    EXPECT_NEAR(report(*world, "anna").position.x, 6.0, 1e-6);
    EXPECT_NEAR(report(*world, "ben").position.x, 8.0, 1e-6);
}

}  // namespace
}  // namespace camrig::world::objects_test
