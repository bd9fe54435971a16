#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/world/world.h"
#include "tests/unit/world/world_fixture.h"

namespace camrig::world::events_test {
namespace {

using namespace world_test;
using testing::ElementsAre;
using testing::HasSubstr;

/// "name@seconds" of all that has fired.
std::vector<std::string> fired(World& world) {
    std::vector<std::string> all;
    for (const EventRecord& record : world.take_records()) {
        all.push_back(record.event + "@" + std::to_string(record.world_ns / ns_per_ms) +
                      (record.actor.empty() ? "" : " " + record.actor));
        EXPECT_THAT(record.errors, ElementsAre());
    }
    return all;
}

TEST(Events, FireAtTimesAndAfterEachOther) {
    auto scene = empty_scene();
    scene->events = {event(R"({"name": "begin", "when": {"at_s": 0}})"),
                     event(R"({"name": "tick", "when": {"every_s": 0.5}, "limit": 3})"),
                     event(R"({"name": "echo", "when": {"event": "tick", "after_s": 0.25}})"),
                     event(R"({"name": "once", "when": {"event": "begin"}})")};
    auto world = World::create(scene, 1).value();
    world->advance_to(3 * ns_per_s);
    EXPECT_THAT(fired(*world), ElementsAre("begin@0", "once@0", "tick@500", "echo@760", "tick@1000", "echo@1260",
                                           "tick@1500", "echo@1760"));
}

TEST(Events, BordersAndMeetingsNameWhoCame) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man", "class": "person", "position": [8, 2, 0], "behaviour":
                               {"type": "go_to", "position": [2, 2, 0]}})"),
                     actor(R"({"name": "ben", "model": "man", "class": "person", "position": [2, 4, 0]})")};
    scene->events = {event(R"({"name": "in", "when": {"enter": "corner"}})"),
                     event(R"({"name": "out", "when": {"leave": "corner", "class": "person"}})"),
                     event(R"({"name": "met", "when": {"meet": ["anna", "ben"], "distance_m": 3}})"),
                     event(R"({"name": "there", "when": {"arrived": "anna"}, "do": [{"action": "behave", "actor": "ben",
                               "behaviour": {"type": "go_to", "position": [9, 4, 0]}}]})")};
    auto world = World::create(scene, 1).value();
    world->advance_to(20 * ns_per_s);
    std::vector<std::string> names;
    for (const std::string& text : fired(*world))
        names.push_back(text.substr(0, text.find('@')) + text.substr(text.find(' ')));
    EXPECT_THAT(names, ElementsAre("in ben", "in anna", "met anna", "there anna", "out ben"));
}

TEST(Events, WhoIsCarriedStaysInHisAreaAndNearOthersUntilHeIsPutDownElsewhere) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man", "position": [3, 3, 0]})"),
                     actor(R"({"name": "ben", "model": "man", "position": [2, 2, 0]})")};
    scene->events = {
        event(R"({"name": "in", "when": {"enter": "corner", "actor": "ben"}})"),
        event(R"({"name": "out", "when": {"leave": "corner", "actor": "ben"}})"),
        event(R"({"name": "met", "when": {"meet": ["anna", "ben"], "distance_m": 3}})"),
        event(
            R"({"name": "take", "when": {"every_s": 1}, "do": [{"action": "pick_up", "object": "ben", "actor": "anna"}]})"),
        event(R"({"name": "put", "when": {"at_s": 1.5}, "do": [
            {"action": "put_down", "object": "ben", "position": [2, 3, 0]}]})"),
        event(R"({"name": "away", "when": {"at_s": 2.5}, "do": [
            {"action": "put_down", "object": "ben", "position": [9, 9, 0]}]})")};
    auto world = World::create(scene, 1).value();
    world->advance_to(2900 * ns_per_ms);
    EXPECT_THAT(fired(*world), ElementsAre("in@0 ben", "met@0 anna", "take@1000", "put@1500", "take@2000", "away@2500",
                                           "out@2520 ben"));
}

TEST(Events, ActionsAreDoneInTheirOrderAtTheInstantOfTheEvent) {
    auto scene = empty_scene();
    ObjectSpec bag;
    bag.name = "bag";
    bag.model = "man";
    bag.position = {3, 2, 0};
    scene->objects = {bag};
    scene->actors = {actor(R"({"name": "anna", "model": "man", "position": [2, 2, 0]})")};
    scene->events = {event(R"({"name": "take", "when": {"at_s": 1}, "do": [
            {"action": "pick_up", "object": "bag", "actor": "anna", "node": "hand"},
            {"action": "behave", "actor": "anna", "behaviour": {"type": "go_to", "position": [6, 2, 0]}},
            {"action": "user", "data": {"level": 2}}]})"),
                     event(R"({"name": "leave", "when": {"arrived": "anna"}, "limit": 1, "do": [
            {"action": "put_down", "object": "bag"}, {"action": "remove", "actor": "anna"},
            {"action": "spawn", "actor": {"name": "guard", "model": "man", "position": [1, 1, 0]}}]})"),
                     event(R"({"name": "night", "when": {"event": "leave"}, "do": [
            {"action": "light", "light": "lamp", "intensity": 0.25},
            {"action": "environment", "sky": [0.1, 0.1, 0.1]},
            {"action": "camera", "camera": "c", "pose": {"position": [1, 2, 3], "look_at": [0, 0, 0]}}]})")};
    auto world = World::create(scene, 1).value();
    world->advance_to(990 * ns_per_ms);
    const auto early = world->snapshot(990 * ns_per_ms);
    EXPECT_EQ(early->statics->objects.size(), 1u);  // the last step is at 1 s, but the picture is from before
    EXPECT_EQ(early->movers.size(), 1u);
    world->advance_to(ns_per_s);
    EXPECT_EQ(world->snapshot(ns_per_s)->statics->objects.size(), 0u);
    EXPECT_EQ(world->snapshot(ns_per_s)->movers.size(), 2u);
    world->advance_to(10 * ns_per_s);
    const auto records = world->take_records();
    ASSERT_EQ(records.size(), 3u);
    EXPECT_THAT(records[0].data, ElementsAre(R"({"level":2})"));
    for (const EventRecord& record : records) EXPECT_THAT(record.errors, ElementsAre()) << record.event;
    EXPECT_EQ(records[1].world_ns, records[2].world_ns);
    const auto end = world->snapshot(10 * ns_per_s);
    ASSERT_EQ(end->movers.size(), 2u);
    EXPECT_EQ(end->movers[0].info->name, "bag");
    EXPECT_EQ(end->movers[0].info->id, ObjectId{1});
    EXPECT_NEAR(end->movers[0].position.x, 6.0, 0.1);
    EXPECT_EQ(end->movers[0].position.z, 0.0);
    EXPECT_EQ(end->movers[1].info->name, "guard");
    EXPECT_EQ(end->statics->lights[0].intensity, 0.25f);
    EXPECT_EQ(end->statics->environment.ambient_sky, glm::vec3(0.1f));
    const auto moves = world->take_camera_moves();
    ASSERT_EQ(moves.size(), 1u);
    EXPECT_EQ(moves[0].world_ns, records[2].world_ns);
}

TEST(Events, ChangesOfCamerasAreBoundedByInstantAndNotByWhenTheyAreTaken) {
    auto scene = empty_scene();
    const std::string change = R"({"action": "camera", "camera": "eye", "vfov_deg": 40})";
    std::string changes = change;
    for (int i = 1; i < 20; ++i) changes += ", " + change;
    const std::string often = R"({"name": "often", "when": {"every_s": 0.01}, "do": [)" + changes + "]}";
    scene->events = {event(often.c_str())};
    auto world = World::create(scene, 1).value();
    world->advance_to(2 * ns_per_s);
    for (const EventRecord& record : world->take_records()) EXPECT_THAT(record.errors, ElementsAre());
    EXPECT_GE(world->take_camera_moves().size(), 20u * 100);
}

TEST(Events, WhatIsPickedUpAndPutDownIsNeverSeenWhereItWasNotBetweenSteps) {
    auto scene = empty_scene();
    ObjectSpec bag;
    bag.name = "bag";
    bag.model = "man";
    bag.position = {3, 2, 0};
    scene->objects = {bag};
    scene->actors = {actor(R"({"name": "cup", "model": "man", "position": [4, 2, 0]})"),
                     actor(R"({"name": "anna", "model": "man", "behaviour":
                               {"type": "route", "route": "line", "speed": 1, "clip": "walk"}})")};
    scene->events = {event(R"({"name": "take", "when": {"at_s": 1}, "do": [
            {"action": "pick_up", "object": "bag", "actor": "anna", "node": "hand"},
            {"action": "pick_up", "object": "cup", "actor": "anna"}]})"),
                     event(R"({"name": "leave", "when": {"at_s": 5}, "do": [
            {"action": "put_down", "object": "bag"}, {"action": "put_down", "object": "cup"}]})")};
    auto world = World::create(scene, 1).value();
    const auto places = [&](TimeNs t) {
        world->advance_to(t);
        const auto snapshot = world->snapshot(t);
        std::map<std::string, glm::dvec2> all;
        for (const Instance& mover : snapshot->movers) all[mover.info->name] = glm::dvec2(mover.position);
        for (const Instance& object : snapshot->statics->objects) all[object.info->name] = glm::dvec2(object.position);
        return all;
    };
    for (TimeNs t = 0; t < 6 * ns_per_s; t += 7 * ns_per_ms) {
        auto place = places(t);
        // Steps are at whole multiples of 20 ms; what an event does shows from its step on, not before.
        const bool is_held = t >= ns_per_s && t < 5 * ns_per_s;
        const double walked = place.at("anna").x;
        for (const auto& [name, lies_at] : {std::pair("bag", 3.0), std::pair("cup", 4.0)}) {
            const double x = is_held ? walked : t < ns_per_s ? lies_at : 5.0;
            ASSERT_NEAR(place.at(name).x, x, 1e-6) << name << " at " << t;
            ASSERT_NEAR(place.at(name).y, t < ns_per_s ? 2.0 : 10.0, 1e-6) << name << " at " << t;
        }
    }
}

TEST(Events, WhoWalksARouteAndIsPutDownBesideItWalksToItAndDoesNotFly) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "ben", "model": "man", "position": [4, 2, 0]})"),
                     actor(R"({"name": "anna", "model": "man", "behaviour":
                               {"type": "route", "route": "line", "speed": 1, "clip": "walk"}})")};
    scene->events = {
        event(
            R"({"name": "take", "when": {"at_s": 1}, "do": [{"action": "pick_up", "object": "anna", "actor": "ben"}]})"),
        event(R"({"name": "leave", "when": {"at_s": 5}, "do": [
            {"action": "put_down", "object": "anna", "position": [8, 2, 0]}]})")};
    auto world = World::create(scene, 1).value();
    world->advance_to(5 * ns_per_s);
    glm::dvec3 before(8, 2, 0);
    for (TimeNs t = 5 * ns_per_s; t <= 30 * ns_per_s; t += 20 * ns_per_ms) {
        world->advance_to(t);
        const glm::dvec3 at = find(*world, "anna").position;
        ASSERT_LT(glm::distance(at, before), 0.1) << t;
        before = at;
    }
    EXPECT_NEAR(before.y, 10.0, 1e-6) << "it is on its route again";
}

TEST(Events, WhoIsCarriedGoesOnWithHisOrdersWhenHeIsPutDown) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man", "position": [2, 2, 0]})"),
                     actor(R"({"name": "ben", "model": "man", "position": [4, 2, 0]})")};
    scene->events = {
        event(
            R"({"name": "take", "when": {"at_s": 1}, "do": [{"action": "pick_up", "object": "anna", "actor": "ben"}]})"),
        event(R"({"name": "put", "when": {"at_s": 3}, "do": [
            {"action": "put_down", "object": "anna", "position": [3, 2, 0]}]})")};
    auto world = World::create(scene, 1).value();
    const SteerSpec go[] = {{.name = "anna", .position = glm::dvec3(6, 2, 0), .over_ns = 4 * ns_per_s}};
    ASSERT_TRUE(world->steer_actors(go));
    world->advance_to(4500 * ns_per_ms);
    EXPECT_NEAR(find(*world, "anna").position.x, 4.5, 1e-6) << "1 s before, 1.5 s since";
    world->advance_to(7 * ns_per_s);
    EXPECT_EQ(find(*world, "anna").position.x, 6.0);
}

TEST(Events, TheClipOfWhoStandsGoesOnEvenlyWhileHeIsCarriedAndAfterwards) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man", "position": [2, 2, 0],
                               "behaviour": {"type": "go_to", "position": [2, 2, 0], "clip": "walk", "idle_clip": "wait"}})"),
                     actor(R"({"name": "ben", "model": "man", "position": [9, 9, 0]})")};
    scene->events = {
        event(
            R"({"name": "take", "when": {"at_s": 1}, "do": [{"action": "pick_up", "object": "anna", "actor": "ben"}]})"),
        event(R"({"name": "put", "when": {"at_s": 2}, "do": [
            {"action": "put_down", "object": "anna", "position": [2, 2, 0]}]})")};
    auto world = World::create(scene, 1).value();
    constexpr TimeNs step_ns = 20 * ns_per_ms, wait_ns = 3 * ns_per_s;
    TimeNs before_ns = -1;
    for (TimeNs t = step_ns; t < 4 * ns_per_s; t += step_ns) {
        world->advance_to(t);
        const auto snapshot = world->snapshot(t);
        const auto anna =
            std::ranges::find(snapshot->movers, "anna", [](const Instance& one) { return one.info->name; });
        ASSERT_EQ(anna->clips.size(), 1u) << t;
        const TimeNs phase_ns = anna->clips[0].phase_ns;
        if (before_ns >= 0) {
            ASSERT_EQ(phase_ns, (before_ns + step_ns) % wait_ns) << t;
        }
        before_ns = phase_ns;
    }
}

TEST(Events, AnEventThatBeginsASequenceDoesNotEndItsFirstStep) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man", "class": "person", "position": [2, 2, 0]})")};
    scene->events = {event(R"({"name": "bell", "when": {"every_s": 2}, "limit": 2})"),
                     event(R"({"name": "begin", "when": {"event": "bell"}, "limit": 1, "do": [
        {"action": "behave", "actor": "anna", "behaviour": {"type": "sequence", "steps": [
            {"type": "stand", "clip": "wait", "until": {"event": "bell"}},
            {"type": "go_to", "position": [8, 2, 0]}]}}]})")};
    auto world = World::create(scene, 1).value();
    world->advance_to(4 * ns_per_s);
    EXPECT_EQ(find(*world, "anna").position, glm::dvec3(2, 2, 0)) << "the bell of 2 s was before it began";
    world->advance_to(15 * ns_per_s);
    EXPECT_LT(glm::distance(find(*world, "anna").position, glm::dvec3(8, 2, 0)), 0.1);
}

TEST(Events, AFlickerEndsWithTheLightAsItWas) {
    auto scene = empty_scene();
    scene->events = {event(R"({"name": "fail", "when": {"at_s": 1}, "do": [
        {"action": "light", "light": "lamp", "flicker_hz": 10, "seconds": 3}]})")};
    auto world = World::create(scene, 1).value();
    std::set<float> seen;
    std::shared_ptr<const StaticSet> before;
    int changes = 0;
    for (TimeNs t = 0; t < 6 * ns_per_s; t += 20 * ns_per_ms) {
        world->advance_to(t);
        const auto statics = world->snapshot(t)->statics;
        seen.insert(statics->lights[0].intensity);
        if (statics != before) ++changes;
        before = statics;
        if (t > 4 * ns_per_s) {
            EXPECT_EQ(statics->lights[0].intensity, 1.0f);
        }
    }
    EXPECT_THAT(seen, ElementsAre(0.0f, 1.0f));
    EXPECT_GT(changes, 5);
    EXPECT_LT(changes, 35);
}

TEST(Events, HeldActorsGoOnWhereTheyStopped) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man",
                               "behaviour": {"type": "route", "route": "line", "speed": 1, "clip": "walk"}})")};
    scene->events = {
        event(R"({"name": "stop", "when": {"at_s": 2}, "do": [{"action": "stop", "actor": "anna", "clip": "wait"}]})"),
        event(R"({"name": "go", "when": {"at_s": 5}, "do": [{"action": "start", "actor": "anna"}]})")};
    auto world = World::create(scene, 1).value();
    world->advance_to(4 * ns_per_s);
    EXPECT_NEAR(find(*world, "anna").position.x, 2.0, 1e-9);
    EXPECT_EQ(find(*world, "anna").clip, "wait");
    world->advance_to(8 * ns_per_s);
    EXPECT_NEAR(find(*world, "anna").position.x, 5.0, 1e-9);
    EXPECT_EQ(find(*world, "anna").clip, "walk");
}

TEST(Events, WhatIsPlayedOverAStopEndsWithTheClipThatWasStopped) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man",
                               "behaviour": {"type": "route", "route": "line", "speed": 1, "clip": "walk"}})")};
    scene->events = {event(R"({"name": "stop", "when": {"at_s": 1}, "do": [{"action": "stop", "actor": "anna"}]})"),
                     event(R"({"name": "wave", "when": {"at_s": 2}, "do": [
            {"action": "play", "actor": "anna", "clip": "wait", "seconds": 1}]})")};
    auto world = World::create(scene, 1).value();
    const auto clips = [&](TimeNs t) {
        world->advance_to(t);
        return world->snapshot(t)->movers.at(0).clips;
    };
    const auto stopped = clips(3 * ns_per_s / 2);
    ASSERT_EQ(stopped.size(), 1u);
    EXPECT_EQ(stopped[0].animation, 0);
    EXPECT_EQ(clips(5 * ns_per_s / 2).at(0).animation, 1);
    const auto again = clips(4 * ns_per_s);
    ASSERT_EQ(again.size(), 1u);
    EXPECT_EQ(again[0].animation, 0);
    EXPECT_EQ(again[0].phase_ns, stopped[0].phase_ns);
}

TEST(Events, ThatAreWrongAreRefusedAndChangeNothing) {
    auto world = World::create(empty_scene(), 1).value();
    world->advance_to(2 * ns_per_s);
    const auto refuse = [&](const char* text) { return world->add_event(event(text)).error().message; };
    EXPECT_THAT(refuse(R"({"name": "a", "when": {"at_s": 1}})"), HasSubstr("when.at_s: is past"));
    EXPECT_THAT(refuse(R"({"name": "a", "when": {"enter": "moon"}})"), HasSubstr("when.enter: no area 'moon'"));
    EXPECT_THAT(refuse(R"({"name": "a", "when": {"event": "b"}})"), HasSubstr("when.event: no event 'b'"));
    EXPECT_THAT(refuse(R"({"name": "a", "when": {"event": "a"}})"),
                HasSubstr("fires itself at one instant: 'a' -> 'a'"));
    EXPECT_THAT(refuse(R"({"name": "a", "when": {"at_s": 9}, "do": [{"action": "remove", "actor": "x"}]})"),
                HasSubstr("do[0].actor: no actor 'x'"));
    EXPECT_TRUE(world->events().empty());
    ASSERT_TRUE(world->add_event(event(R"({"name": "a", "when": {"every_s": 5}})")));
    EXPECT_THAT(refuse(R"({"name": "a", "when": {"every_s": 5}})"), HasSubstr("there is an event 'a'"));
    EXPECT_EQ(world->events().size(), 1u);
    ASSERT_TRUE(world->remove_event("a"));
    EXPECT_FALSE(world->remove_event("a"));
}

TEST(Events, WhatIsDoneAtOnceMayNameWhomItsEarlierActionsSpawn) {
    auto world = World::create(empty_scene(), 1).value();
    const auto act = [&](const std::string& actions) {
        return world->act(event((R"({"name": "x", "when": {"at_s": 99}, "do": [)" + actions + "]}").c_str()).actions);
    };
    const std::string spawn = R"({"action": "spawn", "actor": {"name": "g", "model": "man"}})",
                      play = R"({"action": "play", "actor": "g", "clip": "walk"})",
                      dance = R"({"action": "play", "actor": "g", "clip": "dance"})";
    EXPECT_THAT(act(play + "," + spawn).error().message, HasSubstr("do[0].actor: no actor 'g'"));
    EXPECT_THAT(act(spawn + "," + dance).error().message, HasSubstr("do[1].clip: the model has no clip 'dance'"));
    EXPECT_TRUE(world->actors().empty()) << "where a name is unknown nothing is done";
    const auto done = act(spawn + "," + play);
    ASSERT_TRUE(done) << done.error().message;
    world->advance_to(ns_per_s);
    EXPECT_EQ(find(*world, "g").clip, "walk");
}

TEST(Events, AnActionThatCannotBeDoneAnyMoreIsToldAndTheOthersAreDone) {
    auto scene = empty_scene();
    scene->actors = {actor(R"({"name": "anna", "model": "man"})")};
    scene->events = {event(R"({"name": "twice", "when": {"every_s": 1}, "limit": 2, "do": [
        {"action": "remove", "actor": "anna"}, {"action": "user", "data": 1}]})")};
    auto world = World::create(scene, 1).value();
    world->advance_to(3 * ns_per_s);
    const auto records = world->take_records();
    ASSERT_EQ(records.size(), 2u);
    EXPECT_THAT(records[0].errors, ElementsAre());
    EXPECT_THAT(records[1].errors, ElementsAre(HasSubstr("do[0]: name: there is no actor 'anna'")));
    EXPECT_THAT(records[1].data, ElementsAre("1"));
}

}  // namespace
}  // namespace camrig::world::events_test
