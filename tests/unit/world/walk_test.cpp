#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/world/walk/crowd.h"
#include "core/world/walk/velocity_choice.h"
#include "core/world/walk/walk_area.h"

namespace camrig::world::walk_test {
namespace {

Area square_with_a_block() {
    Area area;
    area.points = {{0, 0}, {10, 0}, {10, 10}, {0, 10}};
    area.obstacles = {{{4, 2}, {6, 2}, {6, 8}, {4, 8}}};
    return area;
}

double excess(const HalfPlane& plane, const glm::dvec2& v) {
    return plane.offset - glm::dot(plane.normal, v);
}

TEST(ChooseVelocity, IsTheNearestOfAllThatObeyByBruteForce) {
    int compared = 0;
    for (std::uint64_t round = 0; round < 300; ++round) {
        std::uint64_t draws = 0;
        const auto number = [&](double low, double high) {
            return low + (high - low) * random_unit(7, round, draws++);
        };
        std::vector<HalfPlane> planes;
        const int count = 1 + static_cast<int>(number(0, 5));
        for (int i = 0; i < count; ++i) {
            const double angle = number(0, 6.28318);
            planes.push_back({{std::cos(angle), std::sin(angle)}, number(-1.0, 0.5)});
        }
        const glm::dvec2 wanted(number(-1.5, 1.5), number(-1.5, 1.5));
        double best = 1e9, least_worst = 1e9;
        for (double x = -1.0; x <= 1.0; x += 0.02) {
            for (double y = -1.0; y <= 1.0; y += 0.02) {
                const glm::dvec2 v(x, y);
                if (glm::length(v) > 1.0) continue;
                double worst = 0.0;
                for (const HalfPlane& plane : planes) worst = std::max(worst, excess(plane, v));
                if (worst <= 0.0) best = std::min(best, glm::distance(v, wanted));
                least_worst = std::min(least_worst, worst);
            }
        }
        const glm::dvec2 chosen = choose_velocity(planes, 0, wanted, 1.0);
        EXPECT_LE(glm::length(chosen), 1.0 + 1e-9);
        double worst = 0.0;
        for (const HalfPlane& plane : planes) worst = std::max(worst, excess(plane, chosen));
        if (best < 1e9) {
            EXPECT_LT(worst, 1e-6) << round;
            EXPECT_LE(glm::distance(chosen, wanted), best + 1e-9) << round;
            ++compared;
        } else {
            EXPECT_LE(worst, least_worst + 1e-6) << round;
        }
    }
    EXPECT_GT(compared, 100);
}

TEST(ChooseVelocity, WallsAreObeyedBeforeOthers) {
    const std::vector<HalfPlane> planes{{{1, 0}, 0.0}, {{-1, 0}, 0.5}};  // a wall to the left, somebody pushing there
    const glm::dvec2 v = choose_velocity(planes, 1, {0, 0}, 1.0);
    EXPECT_GE(v.x, -1e-9);
}

TEST(Avoid, TwoThatObeyItDoNotCollideWithinTheHorizon) {
    for (std::uint64_t round = 0; round < 500; ++round) {
        std::uint64_t draws = 0;
        const auto number = [&](double low, double high) {
            return low + (high - low) * random_unit(9, round, draws++);
        };
        const glm::dvec2 p(number(-3, 3), number(-3, 3)), a(number(-1, 1), number(-1, 1)),
            b(number(-1, 1), number(-1, 1));
        if (glm::length(p) < 0.7) continue;
        const HalfPlane for_a = avoid({p, b, 0.6, 0.5}, a, 2.0, 0.25), for_b = avoid({-p, a, 0.6, 0.5}, b, 2.0, 0.25);
        const glm::dvec2 va = choose_velocity({&for_a, 1}, 0, a, 3.0), vb = choose_velocity({&for_b, 1}, 0, b, 3.0);
        double nearest = 1e9;
        for (double t = 0.0; t <= 2.0; t += 0.01) nearest = std::min(nearest, glm::length(p + (vb - va) * t));
        EXPECT_GT(nearest, 0.6 - 1e-6) << round;
    }
}

TEST(WalkArea, KnowsItsInsideAndItsWalls) {
    const WalkArea area(square_with_a_block(), 0.35);
    EXPECT_TRUE(area.contains({1, 1}));
    EXPECT_FALSE(area.contains({5, 5}));
    EXPECT_FALSE(area.contains({11, 5}));
    EXPECT_DOUBLE_EQ(area.wall_distance({3, 5}), 1.0);
    EXPECT_FALSE(area.has_room({3.9, 5}));
    EXPECT_FALSE(area.is_straight_clear({1, 5}, {9, 5}));
    EXPECT_TRUE(area.is_straight_clear({1, 1}, {9, 1}));
}

TEST(WalkArea, FindsAWayRoundAnObstacle) {
    const WalkArea area(square_with_a_block(), 0.35);
    const auto way = area.find_way({2, 5}, {8, 5.2});
    ASSERT_GE(way.size(), 3u);
    EXPECT_EQ(way.back(), glm::dvec2(8, 5.2));
    double length = 0.0;
    glm::dvec2 at(2, 5);
    for (const glm::dvec2& corner : way) {
        length += glm::distance(at, corner);
        at = corner;
    }
    // Over the top: two legs to the corners at clearance, and the width of the block.
    EXPECT_LT(length, 1.08 * (std::hypot(1.65, 3.35) + 2.7 + std::hypot(1.65, 3.15)));
}

TEST(WalkArea, WithoutAWayItGoesStraight) {
    Area area = square_with_a_block();
    area.obstacles = {{{4, -1}, {6, -1}, {6, 11}, {4, 11}}};
    EXPECT_EQ(WalkArea(area, 0.35).find_way({2, 5}, {8, 5}).back(), glm::dvec2(8, 5));
}

TEST(Crowd, FindsAllWithinTheRange) {
    Crowd crowd;
    std::vector<Body> bodies;
    for (std::uint32_t i = 0; i < 500; ++i) {
        Body body;
        body.id = i;
        body.position = {60.0 * random_unit(1, i, 0) - 30.0, 60.0 * random_unit(1, i, 1) - 30.0};
        bodies.push_back(body);
    }
    crowd.assign(bodies);
    std::vector<const Body*> found;
    for (std::uint32_t i = 0; i < 50; ++i) {
        const glm::dvec2 p(70.0 * random_unit(2, i, 0) - 35.0, 70.0 * random_unit(2, i, 1) - 35.0);
        crowd.near(p, 5.0, found);
        std::size_t within = 0, expected = 0;
        for (const Body* body : found) within += glm::distance(body->position, p) <= 5.0;
        for (const Body& body : bodies) expected += glm::distance(body.position, p) <= 5.0;
        EXPECT_EQ(within, expected);
    }
    crowd.near({0, 0}, 1e8, found);
    EXPECT_EQ(found.size(), 500u);
}

}  // namespace
}  // namespace camrig::world::walk_test
