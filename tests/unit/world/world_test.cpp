#include "core/world/world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/world/behaviour/route_behaviour.h"

namespace camrig::world::world_steps_test {
namespace {

constexpr TimeNs step_ns = 10 * ns_per_ms;

/// A model without vertices that has a clip of `duration_ns` made for a ground speed.
ModelRef walker(TimeNs duration_ns, double ground_speed) {
    auto model = std::make_shared<Model>();
    Animation clip;
    clip.name = "walk";
    clip.duration_ns = duration_ns;
    clip.ground_speed_m_s = ground_speed;
    model->animations.push_back(clip);
    return model;
}

SceneRef walking_scene(double speed = 1.3, RouteBehaviour::Mode mode = RouteBehaviour::Mode::loop) {
    auto scene = std::make_shared<Scene>();
    scene->models["man"] = {.model = walker(1'040'000'001, 1.25),
                            .heading_from_model = glm::angleAxis(std::numbers::pi / 2, glm::dvec3(0, 0, 1))};
    scene->routes["square"] = {.points = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}},
                               .closed = mode == RouteBehaviour::Mode::loop};
    ObjectSpec crate;
    crate.name = "crate";
    crate.model = "man";
    scene->objects.push_back(crate);
    ActorSpec actor;
    actor.name = "anna";
    actor.model = "man";
    actor.behaviour =
        RouteBehaviour{.route = "square", .speed_m_s = speed, .start_m = 2.0, .mode = mode, .clip = "walk"};
    scene->actors.push_back(actor);
    return scene;
}

std::unique_ptr<World> world_of(SceneRef scene) {
    return World::create(std::move(scene), 1).value();
}

TEST(World, ObjectsKeepIdsInTheOrderOfTheScene) {
    auto world = world_of(walking_scene());
    const auto snapshot = world->snapshot(0);
    ASSERT_EQ(snapshot->statics->objects.size(), 1u);
    ASSERT_EQ(snapshot->movers.size(), 1u);
    EXPECT_EQ(snapshot->statics->objects[0].info->id, ObjectId{1});
    EXPECT_EQ(snapshot->movers[0].info->id, ObjectId{2});
}

TEST(World, SnapshotsShareTheirStatics) {
    auto world = world_of(walking_scene());
    const auto first = world->snapshot(0);
    world->advance_to(ns_per_s);
    EXPECT_EQ(world->snapshot(ns_per_s)->statics, first->statics);
}

TEST(World, WhatHappensDoesNotDependOnWhoLooks) {
    auto busy = world_of(walking_scene()), calm = world_of(walking_scene());
    for (TimeNs t = 0; t <= 5 * ns_per_s; t += 3'333'333) {
        busy->advance_to(t);
        (void)busy->snapshot(t);
    }
    const TimeNs end = 5 * ns_per_s + 4'444'444;
    busy->advance_to(end);
    calm->advance_to(end);
    const auto a = busy->snapshot(end), b = calm->snapshot(end);
    EXPECT_EQ(a->movers[0].position, b->movers[0].position);
    EXPECT_EQ(a->movers[0].orientation, b->movers[0].orientation);
    EXPECT_EQ(a->movers[0].clips, b->movers[0].clips);
}

TEST(World, BetweenStepsPlacesAndPhasesLieOnTheWay) {
    auto world = world_of(walking_scene());
    world->advance_to(7 * step_ns);
    const auto before = world->snapshot(6 * step_ns), after = world->snapshot(7 * step_ns);
    const auto middle = world->snapshot(6 * step_ns + step_ns / 4);
    const auto expected = before->movers[0].position * 0.75 + after->movers[0].position * 0.25;
    EXPECT_LT(glm::distance(middle->movers[0].position, expected), 1e-12);
    const TimeNs advance = after->movers[0].clips[0].phase_ns - before->movers[0].clips[0].phase_ns;
    EXPECT_NEAR(static_cast<double>(middle->movers[0].clips[0].phase_ns - before->movers[0].clips[0].phase_ns),
                static_cast<double>(advance) / 4, 1.0);
    EXPECT_NEAR(glm::length(middle->movers[0].velocity), 1.3, 1e-6);
}

TEST(World, TheFrontOfAnActorLooksWhereItWalks) {
    auto world = world_of(walking_scene());
    world->advance_to(ns_per_s);
    const auto mover = world->snapshot(ns_per_s)->movers[0];
    // The model's front is -y in its own frame (glTF +z); heading_from_model turns it to +x.
    const glm::dvec3 front = mover.orientation * glm::dvec3(0, -1, 0);
    EXPECT_LT(glm::distance(front, glm::normalize(mover.velocity)), 1e-6);
}

TEST(World, FeetDoNotSlide) {
    auto world = world_of(walking_scene(2.5));
    world->advance_to(step_ns);
    const auto a = world->snapshot(0)->movers[0], b = world->snapshot(step_ns)->movers[0];
    const double moved = glm::distance(a.position, b.position);
    const double clip_s = static_cast<double>(b.clips[0].phase_ns - a.clips[0].phase_ns) * 1e-9;
    EXPECT_NEAR(clip_s * 1.25, moved, 1e-8);
}

/// A route whose length and a clip whose duration come around together, so that states repeat exactly.
TEST(RouteWalk, PlaceAndPhaseAreTheSameAfterABillionPeriods) {
    const Route line{.points = {{0, 0, 0}, {5, 0, 0}}};  // there and back: 10 m
    RouteWalk walk({.path = std::make_shared<RoutePath>(RoutePath::create(line).value()),
                    .mode = RouteBehaviour::Mode::ping_pong,
                    .speed_m_s = 1.0,
                    .start_m = 0.0,
                    .model = walker(2 * ns_per_s, 0.5),
                    .animation = 0});
    const TimeNs period = 10 * ns_per_s;  // 20 s of clip
    for (const TimeNs offset : {TimeNs{0}, TimeNs{123'456'789}, TimeNs{7'654'321'012}}) {
        ActorState first, later;
        walk.step({.now_ns = offset, .step_ns = step_ns}, first);
        for (const TimeNs k : {TimeNs{1}, TimeNs{1000}, TimeNs{400'000'000}}) {
            walk.step({.now_ns = offset + k * period, .step_ns = step_ns}, later);
            EXPECT_EQ(first.position, later.position);
            EXPECT_EQ(first.orientation, later.orientation);
            EXPECT_EQ(first.clips[0].phase_ns, later.clips[0].phase_ns);
        }
    }
    const auto model = walker(1'000'000'007, 0);
    EXPECT_EQ(clip_at(*model, 0, 5, 0).phase_ns,
              clip_at(*model, 0, 5 + WideInt{1'000'000'007} * 1'000'000'000, 0).phase_ns);
}

TEST(RouteWalk, TurningRoundAtTheEndsIsSmooth) {
    auto world = world_of(walking_scene(1.0, RouteBehaviour::Mode::ping_pong));
    world->advance_to(0);
    auto before = world->snapshot(0)->movers[0];
    for (TimeNs t = step_ns; t < 80 * ns_per_s; t += step_ns) {
        world->advance_to(t);
        const auto now = world->snapshot(t)->movers[0];
        const double angle = 2 * std::acos(std::min(1.0, std::abs(glm::dot(now.orientation, before.orientation))));
        ASSERT_LT(angle, 0.08) << t;
        before = now;
    }
}

TEST(RouteWalk, ModeOnceStopsAtTheEnd) {
    auto scene = std::make_shared<Scene>(*walking_scene(1.0, RouteBehaviour::Mode::once));
    auto world = world_of(scene);
    world->advance_to(100 * ns_per_s);
    const auto mover = world->snapshot(100 * ns_per_s)->movers[0];
    EXPECT_LT(glm::distance(mover.position, glm::dvec3(0, 10, 0)), 1e-8);
    EXPECT_EQ(mover.velocity, glm::dvec3(0));
}

TEST(World, ACopyGoesOnAsTheWorldDoesAndLeavesItAlone) {
    // People on routes, in groups and in sequences, vehicles and events.
    for (const char* const name : {"hall", "street", "crowd"}) {
        const SceneRef scene = load_scene("scenes/" + std::string(name) + ".json").value();
        auto world = world_of(scene), alone = world_of(scene);
        world->advance_to(3 * ns_per_s);
        const auto copy = world->copy();
        copy->advance_to(8 * ns_per_s);
        EXPECT_EQ(world->last_step_ns(), 3 * ns_per_s);
        world->advance_to(8 * ns_per_s);
        alone->advance_to(8 * ns_per_s);
        EXPECT_EQ(copy->state_hash().value, alone->state_hash().value) << name;
        EXPECT_EQ(world->state_hash().value, alone->state_hash().value) << name;
        ASSERT_EQ(copy->snapshot(8 * ns_per_s - 1)->movers.size(), alone->snapshot(8 * ns_per_s - 1)->movers.size());
        (void)copy->remove_actor(scene->actors.front().name);
        EXPECT_EQ(world->actor_count(), alone->actor_count());
    }
}

}  // namespace
}  // namespace camrig::world::world_steps_test
