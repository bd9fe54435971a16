
#include <algorithm>
#include <cmath>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/world/read/follow_graph.h"
#include "core/world/world.h"
#include "tests/unit/world/world_fixture.h"

namespace camrig::world::actors_test {
namespace {

using namespace world_test;
using testing::HasSubstr;

constexpr const char* walker_at_origin = R"({"name": "anna", "model": "man", "class": "person", "position": [2, 2, 0],
    "behaviour": {"type": "go_to", "position": [12, 2, 0], "area": "square", "clip": "walk", "idle_clip": "wait"}})";

TEST(Actors, SpawnedActorsShowFromTheStepAtWhichTheyCame) {
    auto world = World::create(empty_scene(), 1).value();
    world->advance_to(90 * ns_per_ms);  // the last step is at 100 ms
    ASSERT_TRUE(world->spawn_actor(actor(walker_at_origin)));
    EXPECT_EQ(world->last_step_ns(), 100 * ns_per_ms);
    EXPECT_TRUE(world->snapshot(95 * ns_per_ms)->movers.empty());
    EXPECT_EQ(world->snapshot(100 * ns_per_ms)->movers.size(), 1u);
    ASSERT_TRUE(world->remove_actor("anna"));
    EXPECT_TRUE(world->snapshot(100 * ns_per_ms)->movers.empty());
}

TEST(Actors, RemovedActorsShowUntilTheStepAtWhichTheyWent) {
    auto scene = empty_scene();
    scene->actors = {actor(walker_at_origin)};
    auto world = World::create(scene, 1).value();
    world->advance_to(100 * ns_per_ms);
    ASSERT_TRUE(world->remove_actor("anna"));
    EXPECT_EQ(world->snapshot(90 * ns_per_ms)->movers.size(), 1u);
    EXPECT_TRUE(world->snapshot(100 * ns_per_ms)->movers.empty());
    EXPECT_EQ(world->remove_actor("anna").error().kind, ErrorKind::not_found);
}

TEST(Actors, WhoeverGoesSomewhereArrivesThereAndItsFeetDoNotSlide) {
    auto scene = empty_scene();
    scene->actors = {actor(walker_at_origin)};
    auto world = World::create(scene, 1).value();
    double moved = 0.0, clip_s = 0.0;
    for (TimeNs t = 0; t < 15 * ns_per_s; t += scene->step_ns) {
        const auto before = world->snapshot(t)->movers[0];
        world->advance_to(t + scene->step_ns);
        const auto after = world->snapshot(t + scene->step_ns)->movers[0];
        if (after.clips.size() != 1 || before.clips.size() != 1 || after.clips[0].animation != 0 ||
            before.clips[0].animation != 0)
            continue;
        moved += glm::distance(before.position, after.position);
        TimeNs advance = after.clips[0].phase_ns - before.clips[0].phase_ns;
        if (advance < 0) advance += 1'040'000'001;
        clip_s += static_cast<double>(advance) * 1e-9;
    }
    EXPECT_GT(moved, 8.0);
    EXPECT_NEAR(clip_s * walk_ground_m_s, moved, 1e-5);
    const ActorReport anna = find(*world, "anna");
    EXPECT_TRUE(anna.arrived);
    EXPECT_LT(glm::distance(anna.position, glm::dvec3(12, 2, 0)), 0.1);
    EXPECT_EQ(anna.clip, "wait");
}

TEST(Actors, ClipsFadeIntoEachOther) {
    auto scene = empty_scene();
    scene->actors = {actor(walker_at_origin)};
    auto world = World::create(scene, 1).value();
    bool faded = false;
    for (TimeNs t = scene->step_ns; t < 3 * ns_per_s; t += scene->step_ns) {
        world->advance_to(t);
        const auto clips = world->snapshot(t)->movers[0].clips;
        double weight = 0.0;
        for (const ClipState& clip : clips) weight += clip.weight;
        EXPECT_NEAR(weight, 1.0, 1e-12);
        faded = faded || clips.size() == 2;
    }
    EXPECT_TRUE(faded);
}

TEST(Actors, ACommandThatIsWrongChangesNothing) {
    auto scene = empty_scene();
    scene->actors = {actor(walker_at_origin)};
    auto world = World::create(scene, 1).value();
    world->advance_to(ns_per_s);
    const StateHash before = world->state_hash();
    ActorPatch patch{.name = "anna", .position = glm::dvec3(9, 9, 0)};
    patch.behaviour = behaviour(R"({"type": "go_to", "position": [1, 1, 0], "area": "moon"})");
    EXPECT_THAT(world->change_actor(patch).error().message, HasSubstr("behaviour.area: no area 'moon'; known: corner"));
    patch.behaviour = behaviour(R"({"type": "stand", "clip": "dance"})");
    EXPECT_THAT(world->change_actor(patch).error().message, HasSubstr("no clip 'dance'; it has: wait, walk"));
    patch.behaviour = behaviour(R"({"type": "follow", "actor": "nobody"})");
    EXPECT_EQ(world->change_actor(patch).error().kind, ErrorKind::not_found);
    patch.behaviour = behaviour(R"({"type": "follow", "actor": "anna"})");
    EXPECT_THAT(world->change_actor(patch).error().message, HasSubstr("'anna' follows 'anna'"));
    EXPECT_EQ(world->spawn_actor(actor(walker_at_origin)).error().kind, ErrorKind::already_exists);
    const SteerSpec steers[] = {{.name = "anna", .velocity = glm::dvec3(1, 0, 0)}, {.name = "nobody"}};
    EXPECT_THAT(world->steer_actors(steers).error().message, HasSubstr("actors[1].name"));
    EXPECT_EQ(world->state_hash().value, before.value);
    world->advance_to(2 * ns_per_s);
    EXPECT_EQ(find(*world, "anna").behaviour, "go_to");
}

TEST(Actors, FollowersDoNotFollowEachOther) {
    auto scene = empty_scene();
    scene->actors = {actor(walker_at_origin),
                     actor(R"({"name": "ben", "model": "man", "behaviour": {"type": "follow", "actor": "anna"}})")};
    auto world = World::create(scene, 1).value();
    ActorPatch patch{.name = "anna"};
    patch.behaviour = behaviour(R"({"type": "sequence", "steps": [{"type": "follow", "actor": "ben"}]})");
    EXPECT_THAT(world->change_actor(patch).error().message, HasSubstr("'anna' follows 'ben' follows 'anna'"));
}

TEST(FollowGraph, FindsWhoIsOnACircleAndNotWhoOnlyLeadsIntoOne) {
    FollowGraph graph;
    const auto follows = [&](const char* who, const char* whom) { graph.add(who, FollowBehaviour{.actor = whom}); };
    follows("lost", "a");
    follows("a", "b");
    follows("b", "end");
    follows("b", "a");
    follows("a", "c");
    follows("c", "b");
    follows("self", "self");
    EXPECT_EQ(graph.circle_of("lost"), std::nullopt);
    EXPECT_EQ(graph.circle_of("a"), "'a' follows 'b' follows 'a'");
    EXPECT_EQ(graph.circle_of("b"), "'b' follows 'a' follows 'b'");
    EXPECT_EQ(graph.circle_of("c"), "'c' follows 'b' follows 'a' follows 'c'");
    EXPECT_EQ(graph.circle_of("self"), "'self' follows 'self'");
    EXPECT_EQ(graph.circle_of("end"), std::nullopt);
    EXPECT_EQ(graph.circle_of("nobody"), std::nullopt);
}

TEST(Actors, FollowersKeepTheirDistance) {
    auto scene = empty_scene();
    scene->actors = {actor(walker_at_origin), actor(R"({"name": "ben", "model": "man", "class": "person", "position":
        [0.5, 4, 0], "behaviour": {"type": "follow", "actor": "anna", "distance_m": 1.5, "clip": "walk"}})")};
    auto world = World::create(scene, 1).value();
    world->advance_to(20 * ns_per_s);
    const double distance = glm::distance(find(*world, "anna").position, find(*world, "ben").position);
    EXPECT_GT(distance, 1.0);
    EXPECT_LT(distance, 2.0);
}

TEST(Actors, AGroupStandsInACircleAndFacesItsMiddle) {
    auto scene = empty_scene();
    for (int i = 0; i < 4; ++i) {
        ActorSpec member = actor(R"({"name": "m", "model": "man", "class": "person", "behaviour": {"type": "group",
            "group": "talkers", "position": [10, 10, 0], "radius_m": 0.9, "clip": "walk", "idle_clip": "wait"}})");
        member.name += std::to_string(i);
        member.position = {4.0 + 3.0 * i, 3.0 + i, 0.0};
        scene->actors.push_back(member);
    }
    auto world = World::create(scene, 1).value();
    world->advance_to(30 * ns_per_s);
    for (const ActorReport& member : world->actors()) {
        const glm::dvec3 to_middle = glm::dvec3(10, 10, 0) - member.position;
        EXPECT_NEAR(glm::length(to_middle), 0.9, 0.1) << member.name;
        EXPECT_GT(glm::dot(glm::normalize(to_middle), member.orientation * glm::dvec3(1, 0, 0)), 0.99) << member.name;
    }
}

TEST(Actors, WhoJoinsAGroupInAStepOfASequenceHasAPlaceOfTheCircleToo) {
    auto scene = empty_scene();
    const std::string group = R"({"type": "group", "group": "talkers", "position": [10, 10, 0], "radius_m": 0.9})";
    for (int i = 0; i < 4; ++i) {
        ActorSpec member = actor(R"({"name": "m", "model": "man", "class": "person"})");
        member.behaviour = behaviour(
            (i == 0 ? group
                    : R"({"type": "sequence", "steps": [{"type": "go_to", "position": [9, 6, 0]},)" + group + "]}")
                .c_str());
        member.name += std::to_string(i);
        member.position = {4.0 + 3.0 * i, 3.0 + i, 0.0};
        scene->actors.push_back(member);
    }
    auto world = World::create(scene, 1).value();
    world->advance_to(40 * ns_per_s);
    const auto members = world->actors();
    for (const ActorReport& member : members) {
        EXPECT_NEAR(glm::length(glm::dvec3(10, 10, 0) - member.position), 0.9, 0.1) << member.name;
        for (const ActorReport& other : members)
            if (other.name != member.name) {
                EXPECT_GT(glm::distance(other.position, member.position), 1.0) << member.name << " and " << other.name;
            }
    }
}

TEST(Actors, SteeredActorsMoveAsTheyAreTold) {
    auto scene = empty_scene();
    scene->actors = {actor(walker_at_origin)};
    auto world = World::create(scene, 1).value();
    const SteerSpec walk[] = {{.name = "anna", .velocity = glm::dvec3(0, 1, 0), .clip = "walk"}};
    ASSERT_TRUE(world->steer_actors(walk));
    world->advance_to(2 * ns_per_s);
    EXPECT_LT(glm::distance(find(*world, "anna").position, glm::dvec3(2, 4, 0)), 1e-9);
    EXPECT_NEAR((find(*world, "anna").orientation * glm::dvec3(1, 0, 0)).y, 1.0, 1e-9);
    const SteerSpec glide[] = {{.name = "anna", .position = glm::dvec3(5, 4, 0), .over_ns = ns_per_s, .yaw_rad = 0.0}};
    ASSERT_TRUE(world->steer_actors(glide));
    world->advance_to(2 * ns_per_s + ns_per_s / 2);
    EXPECT_LT(glm::distance(find(*world, "anna").position, glm::dvec3(3.5, 4, 0)), 1e-9);
    world->advance_to(4 * ns_per_s);
    EXPECT_LT(glm::distance(find(*world, "anna").position, glm::dvec3(5, 4, 0)), 1e-9);
}

TEST(Actors, ASequenceGoesOnWhenAStepHasArrivedOrItsTimeIsOver) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man", "class": "person", "position": [1, 1, 0], "behaviour":
        {"type": "sequence", "steps": [
            {"type": "stand", "clip": "wait", "until": {"seconds": 1}},
            {"type": "go_to", "position": [4, 1, 0], "clip": "walk"},
            {"type": "look_at", "position": [4, 9, 0]}]}})")};
    auto world = World::create(scene, 1).value();
    world->advance_to(ns_per_s);
    EXPECT_EQ(find(*world, "anna").position, glm::dvec3(1, 1, 0));
    EXPECT_FALSE(find(*world, "anna").arrived);
    world->advance_to(10 * ns_per_s);
    EXPECT_LT(glm::distance(find(*world, "anna").position, glm::dvec3(4, 1, 0)), 0.1);
    EXPECT_NEAR((find(*world, "anna").orientation * glm::dvec3(1, 0, 0)).y, 1.0, 1e-3);
    EXPECT_TRUE(find(*world, "anna").arrived);
}

TEST(Actors, WhoJoinsARouteDoesNotJumpOntoIt) {
    auto scene = empty_scene();
    scene->routes["high"] = {.points = {{0, 10, 3}, {20, 10, 5}}};
    scene->actors = {actor(R"({"name": "drone", "model": "man", "position": [1, 5, 0]})")};
    auto world = World::create(scene, 1).value();
    ActorPatch patch{.name = "drone"};
    patch.behaviour = behaviour(R"({"type": "route", "route": "high", "speed": 1})");
    ASSERT_TRUE(world->change_actor(patch));
    glm::dvec3 before = find(*world, "drone").position;
    for (TimeNs t = 0; t <= 20 * ns_per_s; t += 20 * ns_per_ms) {
        world->advance_to(t);
        const glm::dvec3 at = find(*world, "drone").position;
        ASSERT_LE(glm::distance(at, before), 0.05) << t;
        before = at;
    }
    EXPECT_NEAR(before.y, 10.0, 1e-6);
    EXPECT_NEAR(before.z, 3.0 + before.x / 10.0, 0.01);
}

TEST(Actors, WhoIsSentToARouteWalksThere) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man", "class": "person", "position": [1, 5, 0]})")};
    auto world = World::create(scene, 1).value();
    ActorPatch patch{.name = "anna"};
    patch.behaviour = behaviour(R"({"type": "route", "route": "line", "clip": "walk"})");
    ASSERT_TRUE(world->change_actor(patch));
    glm::dvec3 at = find(*world, "anna").position;
    for (TimeNs t = scene->step_ns; t < 15 * ns_per_s; t += scene->step_ns) {
        world->advance_to(t);
        const glm::dvec3 next = find(*world, "anna").position;
        ASSERT_LT(glm::distance(at, next), 0.06) << t;
        at = next;
    }
    EXPECT_NEAR(at.y, 10.0, 1e-6);
}

TEST(Actors, AVehicleStopsBehindSomebodyOnItsLaneAndGoesOn) {
    auto scene = empty_scene();
    scene->routes["lane"] = {.points = {{0, 0, 0}, {400, 0, 0}}};
    scene->actors = {actor(R"({"name": "car", "model": "man", "class": "vehicle",
                               "behaviour": {"type": "vehicle", "route": "lane", "speed": 12}})"),
                     actor(R"({"name": "anna", "model": "man", "class": "person", "position": [100, 0.5, 0]})")};
    auto world = World::create(scene, 1).value();
    double speed = 12.0, hardest = 0.0;
    for (TimeNs t = scene->step_ns; t <= 40 * ns_per_s; t += scene->step_ns) {
        world->advance_to(t);
        const double now = glm::length(find(*world, "car").velocity);
        hardest = std::max(hardest, (speed - now) / 0.02);
        speed = now;
    }
    const double bumper = find(*world, "car").position.x + 4.5 / 2;
    EXPECT_LT(bumper, 100.0 - person_radius_m - 0.5);
    EXPECT_GT(bumper, 100.0 - 4.0);
    EXPECT_LT(speed, 0.1);
    EXPECT_LT(hardest, 5.0);  // it saw her early
    ASSERT_TRUE(world->remove_actor("anna"));
    world->advance_to(60 * ns_per_s);
    EXPECT_GT(find(*world, "car").position.x, 150.0);
}

TEST(Actors, VehiclesOfOneLaneQueueUp) {
    auto scene = empty_scene();
    scene->routes["lane"] = {.points = {{0, 0, 0}, {300, 0, 0}}};
    scene->actors = {actor(R"({"name": "first", "model": "man",
                               "behaviour": {"type": "vehicle", "route": "lane", "speed": 5, "start_m": 30}})"),
                     actor(R"({"name": "second", "model": "man",
                               "behaviour": {"type": "vehicle", "route": "lane", "speed": 15}})")};
    auto world = World::create(scene, 1).value();
    double least = 1e9;
    for (TimeNs t = scene->step_ns; t <= 90 * ns_per_s; t += scene->step_ns) {
        world->advance_to(t);
        least = std::min(least, find(*world, "first").position.x - find(*world, "second").position.x - 4.5);
    }
    EXPECT_GT(least, 1.0);
    EXPECT_NEAR(find(*world, "first").position.x, 300.0, 0.5);  // it stops at the end of the lane
}

TEST(Actors, AVehicleInASequenceDrivesFromOneLaneToTheNextWithoutAJump) {
    auto scene = empty_scene();
    scene->routes["first"] = {.points = {{0, 0, 0}, {40, 0, 0}}};
    scene->routes["second"] = {.points = {{20, 6, 0}, {200, 6, 0}}};
    scene->actors = {actor(R"({"name": "car", "model": "man", "class": "vehicle", "behaviour": {"type": "sequence",
        "steps": [{"type": "vehicle", "route": "first", "speed": 10, "until": {"seconds": 4}},
                  {"type": "vehicle", "route": "second", "speed": 10}]}})")};
    auto world = World::create(scene, 1).value();
    glm::dvec3 at = find(*world, "car").position;
    double speed = 0.0;
    for (TimeNs t = scene->step_ns; t <= 15 * ns_per_s; t += scene->step_ns) {
        world->advance_to(t);
        const glm::dvec3 next = find(*world, "car").position;
        const double now = glm::distance(at, next) / (static_cast<double>(scene->step_ns) * 1e-9);
        ASSERT_LT(now, 13.0) << "at " << at.x << ", " << at.y;
        ASSERT_LT(std::abs(now - speed), 0.5) << "at " << at.x << ", " << at.y;
        at = next;
        speed = now;
    }
    EXPECT_GT(at.x, 80.0);
    EXPECT_NEAR(at.y, 6.0, 1e-9);  // on the second lane
}

TEST(Actors, ADroneFliesItsPathThroughTheAir) {
    auto scene = empty_scene();
    scene->routes["path"] = {.points = {{0, 0, 5}, {30, 0, 8}, {30, 20, 12}, {0, 20, 6}}, .closed = true};
    scene->actors = {actor(R"({"name": "drone", "model": "man", "class": "drone",
        "behaviour": {"type": "route", "route": "path", "speed": 4}})")};
    auto world = World::create(scene, 1).value();
    double least = 1e9, most = 0.0, walked = 0.0;
    glm::dvec3 at = find(*world, "drone").position;
    for (TimeNs t = scene->step_ns; t <= 60 * ns_per_s; t += scene->step_ns) {
        world->advance_to(t);
        const glm::dvec3 next = find(*world, "drone").position;
        const double moved = glm::distance(at, next);
        ASSERT_NEAR(moved, 4.0 * static_cast<double>(scene->step_ns) * 1e-9, 1e-4);  // chords of the corners
        walked += moved;
        least = std::min(least, next.z);
        most = std::max(most, next.z);
        at = next;
    }
    EXPECT_NEAR(walked, 240.0, 0.1);
    EXPECT_LT(least, 5.5);
    EXPECT_GT(most, 11.0);
    // It looks along its way over the ground, level.
    const glm::dvec3 front = find(*world, "drone").orientation * glm::dvec3(1.0, 0.0, 0.0);
    const glm::dvec3 velocity = find(*world, "drone").velocity;
    EXPECT_NEAR(front.z, 0.0, 1e-12);
    EXPECT_NEAR(glm::dot(glm::dvec2(front), glm::normalize(glm::dvec2(velocity))), 1.0, 1e-3);
}

TEST(Actors, AnObjectInAHandGoesWithIt) {
    auto scene = empty_scene();
    ObjectSpec bag;
    bag.name = "bag";
    bag.model = "man";
    bag.attach = Attachment{.actor = "anna", .node = "hand", .position = {0, 0, 0}, .orientation = {1, 0, 0, 0}};
    scene->objects = {bag};
    scene->actors = {actor(walker_at_origin)};
    auto world = World::create(scene, 1).value();
    world->advance_to(4 * ns_per_s);
    const auto snapshot = world->snapshot(4 * ns_per_s - 7 * ns_per_ms);
    ASSERT_EQ(snapshot->movers.size(), 2u);
    const Instance &anna = snapshot->movers[0], &held = snapshot->movers[1];
    EXPECT_EQ(held.info->name, "bag");
    EXPECT_EQ(held.info->id, ObjectId{1});
    EXPECT_LT(glm::distance(held.position, anna.position + glm::dvec3(0, 0, 1)), 1e-9);
    EXPECT_EQ(held.velocity, anna.velocity);
}

TEST(Actors, WhoIsGoneTakesNoPlaceInAWorldThatStandsStill) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man"})")};
    auto world = World::create(scene, 1).value();
    const ActorSpec guest = actor(R"({"name": "guest", "model": "man"})");
    for (std::size_t i = 0; i < max_world_actors + 10; ++i) {
        const auto come = world->spawn_actor(guest);
        ASSERT_TRUE(come) << i << ": " << come.error().message;
        ASSERT_TRUE(world->remove_actor("guest"));
    }
    ObjectSpec fan{.name = "fan", .model = "man", .clip = "wait", .attach = {}};
    EXPECT_TRUE(world->spawn_object(fan));
    EXPECT_EQ(world->actors().size(), 1u);
    world->advance_to(ns_per_s);
    EXPECT_EQ(world->snapshot(ns_per_s)->movers.size(), 2u);
}

TEST(Actors, WhoCarriedSomebodyThatIsGoneCanBeCarriedAtOnce) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man"})"), actor(R"({"name": "ben", "model": "man"})"),
                     actor(R"({"name": "bird", "model": "man", "attach": {"actor": "ben"}})")};
    auto world = World::create(scene, 1).value();
    ActorPatch patch{.name = "ben", .attach = Attachment{.actor = "anna", .node = {}}};
    EXPECT_THAT(world->change_actor(patch).error().message, HasSubstr("'ben' carries something itself"));
    ASSERT_TRUE(world->remove_actor("bird"));
    const auto hung = world->change_actor(patch);
    ASSERT_TRUE(hung) << hung.error().message;
    EXPECT_EQ(hung->attached_to, "anna");
}

TEST(Actors, WhatHangsOnSomebodyPlaysItsClipOn) {
    auto scene = empty_scene();
    ObjectSpec fan{.name = "fan", .model = "man", .clip = "wait", .attach = Attachment{.actor = "anna", .node = {}}};
    scene->objects = {fan};
    scene->actors = {actor(R"({"name": "bird", "model": "man", "behaviour": {"type": "stand", "clip": "wait"}})"),
                     actor(R"({"name": "ben", "model": "man",
                               "behaviour": {"type": "route", "route": "line", "speed": 1, "clip": "walk"}})"),
                     actor(R"({"name": "anna", "model": "man"})")};
    scene->events = {event(R"({"name": "take", "when": {"at_s": 1}, "do": [
            {"action": "pick_up", "object": "bird", "actor": "anna"},
            {"action": "pick_up", "object": "ben", "actor": "anna"}]})")};
    auto world = World::create(scene, 1).value();
    std::set<TimeNs> steps_of_ben;
    for (TimeNs t = 0; t < 5 * ns_per_s; t += 7 * ns_per_ms) {
        world->advance_to(t);
        const auto snapshot = world->snapshot(t);
        for (const Instance& mover : snapshot->movers) {
            if (mover.info->name == "anna") continue;
            ASSERT_EQ(mover.clips.size(), 1u) << mover.info->name << " at " << t;
            const TimeNs phase_ns = mover.clips[0].phase_ns;
            if (mover.info->name != "ben") {
                ASSERT_EQ(phase_ns, t % (3 * ns_per_s)) << mover.info->name << " at " << t;
            } else if (t >= ns_per_s) {
                steps_of_ben.insert(phase_ns);
            }
        }
    }
    EXPECT_EQ(steps_of_ben.size(), 1u) << "who is carried walks no way, and his feet stand still";
    ActorPatch patch{.name = "ben"};
    patch.behaviour = behaviour(R"({"type": "stand", "clip": "wait"})");
    ASSERT_TRUE(world->change_actor(patch));
    world->advance_to(6 * ns_per_s);
    EXPECT_EQ(find(*world, "ben").clip, "wait") << "another behaviour has another clip";
}

TEST(Actors, NothingHangsFromTheStartOnWhomAnEventBrings) {
    auto scene = empty_scene();
    ObjectSpec bag;
    bag.name = "bag";
    bag.model = "man";
    bag.attach = Attachment{.actor = "ghost", .node = {}};
    scene->objects = {bag};
    scene->actors = {actor(R"({"name": "anna", "model": "man"})")};
    scene->events = {event(R"({"name": "come", "when": {"at_s": 1}, "do": [
        {"action": "spawn", "actor": {"name": "ghost", "model": "man"}},
        {"action": "spawn", "actor": {"name": "bird", "model": "man", "attach": {"actor": "ghost"}}}]})")};
    const char* const why = "attach.actor: 'ghost' comes by an event only; there from the start: anna";
    EXPECT_THAT(World::create(scene, 1).error().message, HasSubstr(why));
    scene->objects.clear();
    scene->actors[0].attach = bag.attach;
    EXPECT_THAT(World::create(scene, 1).error().message, HasSubstr(why));
    scene->actors[0].attach.reset();
    auto world = World::create(scene, 1).value();
    ActorSpec fly = actor(R"({"name": "fly", "model": "man", "attach": {"actor": "ghost"}})");
    EXPECT_THAT(world->spawn_actor(fly).error().message, HasSubstr("attach.actor: no actor 'ghost'; known: anna"));
    world->advance_to(ns_per_s);
    EXPECT_EQ(find(*world, "bird").attached_to, "ghost") << "what comes by events may hang on each other";
    EXPECT_TRUE(world->spawn_actor(fly));
}

TEST(Actors, AnEventThatHangsSomebodyOnWhoIsNotThereIsTold) {
    auto world = World::create(empty_scene(), 1).value();
    ASSERT_TRUE(world->add_event(event(R"({"name": "come", "when": {"at_s": 1}, "do": [
        {"action": "spawn", "actor": {"name": "bird", "model": "man", "attach": {"actor": "ghost"}}},
        {"action": "spawn", "actor": {"name": "ghost", "model": "man"}}]})")));
    world->advance_to(ns_per_s);
    const auto records = world->take_records();
    ASSERT_EQ(records.size(), 1u);
    EXPECT_THAT(records[0].errors, testing::ElementsAre(HasSubstr("do[0]: attach.actor: no actor 'ghost'")));
    EXPECT_EQ(world->actors().size(), 1u);
}

TEST(Actors, WhatHangsOnSomebodyIsSeenWhereItIs) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "bird", "model": "man", "position": [9, 9, 0],
                               "attach": {"actor": "anna", "node": "hand"}})"),
                     actor(R"({"name": "anna", "model": "man", "class": "person",
                               "behaviour": {"type": "route", "route": "line", "speed": 1, "clip": "walk"}})"),
                     actor(R"({"name": "ben", "model": "man", "class": "person", "position": [15, 5, 0],
                               "behaviour": {"type": "look_at", "actor": "bird"}})"),
                     actor(R"({"name": "carl", "model": "man", "class": "person", "position": [0, 15, 0],
                               "behaviour": {"type": "follow", "actor": "bird", "distance_m": 1.5}})")};
    auto world = World::create(scene, 1).value();
    world->advance_to(15 * ns_per_s);
    const glm::dvec3 bird = find(*world, "bird").position;
    EXPECT_LT(glm::distance(glm::dvec2(bird), glm::dvec2(find(*world, "anna").position)), 0.01);
    EXPECT_NEAR(bird.x, 15.0, 0.01);
    const glm::dvec3 front = find(*world, "ben").orientation * glm::dvec3(1, 0, 0);
    EXPECT_NEAR(front.y, 1.0, 0.01) << "the bird is straight ahead of him now";
    EXPECT_LT(glm::distance(glm::dvec2(find(*world, "carl").position), glm::dvec2(bird)), 2.5);
}

TEST(Actors, WhoJoinsARouteBeyondItsEndBeginsWhereItWrapsTo) {
    for (const bool closed : {false, true}) {
        auto scene = empty_scene();
        scene->routes["loop"] = {.points = {{0, 10, 0}, {20, 10, 0}, {20, 14, 0}, {0, 14, 0}}, .closed = closed};
        scene->actors = {actor(R"({"name": "anna", "model": "man", "class": "person", "position": [5, 9, 0]})")};
        auto world = World::create(scene, 1).value();
        ActorPatch patch{.name = "anna"};
        patch.behaviour = behaviour(R"({"type": "route", "route": "loop", "start_m": 95, "clip": "walk"})");
        ASSERT_TRUE(world->change_actor(patch));
        glm::dvec3 at = find(*world, "anna").position;
        for (TimeNs t = scene->step_ns; t < 30 * ns_per_s; t += scene->step_ns) {
            world->advance_to(t);
            const glm::dvec3 next = find(*world, "anna").position;
            ASSERT_LT(glm::distance(at, next), 0.09) << closed << " " << t;
            at = next;
        }
    }
}

}  // namespace
}  // namespace camrig::world::actors_test
