#include "core/world/step_history.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/unit/world/world_fixture.h"

namespace camrig::world::step_history_test {
namespace {

using namespace world_test;

/// All that a snapshot shows, as numbers that are equal only where every bit is.
std::vector<double> numbers_of(const Snapshot& snapshot) {
    std::vector<double> numbers = {static_cast<double>(snapshot.world_ns)};
    for (const Light& light : snapshot.statics->lights) numbers.push_back(light.intensity);
    for (const Instance& mover : snapshot.movers) {
        const auto id = static_cast<double>(static_cast<std::uint32_t>(mover.info->id));
        const glm::dvec3 &p = mover.position, &v = mover.velocity;
        const glm::dquat& q = mover.orientation;
        numbers.insert(numbers.end(), {id, mover.scale, p.x, p.y, p.z, v.x, v.y, v.z, q.x, q.y, q.z, q.w});
        for (const ClipState& clip : mover.clips)
            numbers.insert(numbers.end(),
                           {static_cast<double>(clip.animation), static_cast<double>(clip.phase_ns), clip.weight});
    }
    return numbers;
}

/// People who walk, carry, put down, come and go, under a lamp that flickers.
std::unique_ptr<World> busy_world(TimeNs step_ns) {
    const auto scene = empty_scene(step_ns);
    scene->actors = {
        actor(
            R"({"name": "a", "model": "man", "behaviour": {"type": "wander", "area": "square", "clip": "walk", "idle_clip": "wait"}})"),
        actor(R"({"name": "b", "model": "man", "position": [3, 3, 0]})")};
    scene->events = {
        event(
            R"({"name": "flicker", "when": {"at_s": 0.05}, "do": [{"action": "light", "light": "lamp", "flicker_hz": 25}]})"),
        event(
            R"({"name": "take", "when": {"every_s": 0.31}, "do": [{"action": "pick_up", "object": "b", "actor": "a", "node": "hand"}]})"),
        event(R"({"name": "put", "when": {"every_s": 0.47}, "do": [{"action": "put_down", "object": "b"}]})"),
        event(
            R"({"name": "come", "when": {"every_s": 0.4}, "do": [{"action": "spawn", "actor": {"name": "c", "model": "man", "position": [9, 9, 0]}}]})"),
        event(R"({"name": "go", "when": {"every_s": 0.6}, "do": [{"action": "remove", "actor": "c"}]})")};
    return World::create(scene, 7).value();
}

class StepHistoryTest : public testing::TestWithParam<TimeNs> {};

TEST_P(StepHistoryTest, WhatWasIsSeenLaterAsItWasSeenThen) {
    const TimeNs step_ns = GetParam();
    const auto world = busy_world(step_ns);
    struct Seen {
        TimeNs world_ns;
        std::vector<double> numbers;
    };
    std::vector<Seen> seen;
    for (std::uint64_t i = 0; i < 600; ++i) {
        // Some ns to 40 ms further each time; every fifth time at a step.
        TimeNs next_ns =
            (seen.empty() ? 0 : seen.back().world_ns) + 1 + static_cast<TimeNs>(random_unit(1, 2, i) * 40 * ns_per_ms);
        if (i % 5 == 0) next_ns = (next_ns / step_ns + 1) * step_ns;
        world->advance_to(next_ns);
        seen.push_back({next_ns, numbers_of(*world->snapshot(next_ns))});
        // Whatever time of the last quarter of a second, in any order.
        const TimeNs oldest_ns = std::max<TimeNs>(0, world->last_step_ns() - StepHistory::span_ns);
        std::vector<const Seen*> again;
        for (const Seen& one : seen)
            if (one.world_ns >= oldest_ns) again.push_back(&one);
        for (std::size_t k = again.size(); k > 1; --k) std::swap(again[k - 1], again[random_bits(3, i, k) % k]);
        for (const Seen* one : again)
            ASSERT_EQ(numbers_of(*world->snapshot(one->world_ns)), one->numbers) << one->world_ns << " at " << next_ns;
    }
    // All of it happened.
    const auto differs = [&](std::size_t index) {
        return std::ranges::any_of(seen,
                                   [&](const Seen& one) { return one.numbers[index] != seen.front().numbers[index]; });
    };
    EXPECT_TRUE(differs(1)) << "the lamp";
    EXPECT_NE(std::ranges::min(seen, {}, [](const Seen& one) { return one.numbers.size(); }).numbers.size(),
              std::ranges::max(seen, {}, [](const Seen& one) { return one.numbers.size(); }).numbers.size())
        << "who comes and goes";
}

TEST_P(StepHistoryTest, AQuarterOfASecondIsKeptAndNotMuchMore) {
    const auto world = busy_world(GetParam());
    for (TimeNs at_ns = 0; at_ns < 2 * ns_per_s; at_ns += 7 * ns_per_ms) {
        world->advance_to(at_ns);
        const TimeNs oldest_ns = std::max<TimeNs>(0, world->last_step_ns() - StepHistory::span_ns);
        EXPECT_EQ(world->snapshot(oldest_ns)->world_ns, oldest_ns);
    }
    StepHistory history;
    for (TimeNs at_ns = 0; at_ns <= ns_per_s; at_ns += GetParam()) {
        StepRecord record;
        record.world_ns = at_ns;
        history.push(std::move(record));
    }
    EXPECT_GE(history.oldest_ns({}), ns_per_s - StepHistory::span_ns - 2 * GetParam());
}

INSTANTIATE_TEST_SUITE_P(Steps, StepHistoryTest, testing::Values(1 * ns_per_ms, 20 * ns_per_ms, 100 * ns_per_ms));

TEST(StepHistory, ACommandShowsFromItsStepOnAndNotBefore) {
    const auto world = World::create(empty_scene(), 1).value();
    ASSERT_TRUE(world->spawn_actor(actor(R"({"name": "a", "model": "man", "position": [1, 0, 0]})")));
    world->advance_to(100 * ns_per_ms);
    ActorPatch away{.name = "a"};
    away.position = glm::dvec3(5, 0, 0);
    ASSERT_TRUE(world->change_actor(away));
    world->advance_to(180 * ns_per_ms);
    const auto x_at = [&](TimeNs ns) { return world->snapshot(ns)->movers.front().position.x; };
    EXPECT_EQ(x_at(100 * ns_per_ms - 1), 1.0);
    EXPECT_EQ(x_at(100 * ns_per_ms), 5.0);
    EXPECT_EQ(x_at(100 * ns_per_ms + 1), 5.0);
}

}  // namespace
}  // namespace camrig::world::step_history_test
