#include <cmath>
#include <iostream>
#include <map>

#include <gtest/gtest.h>

#include "core/world/walk/walk_area.h"
#include "core/world/world.h"
#include "tests/unit/world/crowd_watch.h"

// The shipped outdoor scenes keep what docs/actors.md says of them.
namespace camrig::world::scenes_test {
namespace {

using namespace world_test;

/// The scene with coarser steps than its own: ten minutes in a fraction of the time.
std::unique_ptr<World> coarse(const char* file, TimeNs step_ns) {
    auto scene = load_scene(file);
    EXPECT_TRUE(scene) << scene.error().message;
    if (!scene) return nullptr;
    auto copy = std::make_shared<Scene>(**scene);
    copy->step_ns = step_ns;
    return World::create(copy, copy->seed).value();
}

TEST(Crowd, NobodyWalksThroughSomebodyOrSomethingInTenMinutes) {
    const auto world = coarse("scenes/crowd.json", 100 * ns_per_ms);
    ASSERT_TRUE(world);
    EXPECT_EQ(world->actor_count(), 100u);
    Area square = world->scene().areas.at("square");
    const Depths depths = watch(*world, square, 600 * ns_per_s, "sitter");
    std::cout << "deepest: bodies " << depths.bodies_m << " m (" << depths.worst << "), walls " << depths.walls_m
              << " m; walked " << depths.walked_m << " m\n";
    EXPECT_LT(depths.bodies_m, 0.06);
    EXPECT_LT(depths.walls_m, 0.02);
    EXPECT_GT(depths.walked_m, 70 * 600 * 0.5);
}

/// The nearest that the hulls of two cars came; boxes of length and width about their middles, on straight lanes.
struct Traffic {
    double gap_m = 1e9;         ///< of two cars of one lane, bumper to bumper
    double person_gap_m = 1e9;  ///< of a person's disc and a car's box
    double driven_m = 0.0;
    std::string worst;
};

double gap_to_box(const glm::dvec2& p, const glm::dvec3& middle, const glm::dvec3& ahead, double length, double width) {
    const glm::dvec2 x = glm::normalize(glm::dvec2(ahead)), to = p - glm::dvec2(middle);
    const double u = std::abs(glm::dot(to, x)) - length / 2.0;
    const double v = std::abs(x.x * to.y - x.y * to.x) - width / 2.0;
    return u > 0.0 && v > 0.0 ? std::hypot(u, v) : std::max(u, v);
}

double gap_to_box(const glm::dvec2& p, const Instance& car, double length, double width) {
    const glm::dvec3 ahead = car.orientation * glm::inverse(car.info->heading_from_model) * glm::dvec3(1, 0, 0);
    return gap_to_box(p, car.position, ahead, length, width);
}

TEST(Street, CarsKeepTheirDistanceAndSparePeopleForTenMinutes) {
    const auto world = coarse("scenes/street.json", 100 * ns_per_ms);
    ASSERT_TRUE(world);
    std::map<std::string, double> lengths;
    for (const ActorSpec& actor : world->scene().actors)
        if (const auto* vehicle = std::get_if<VehicleBehaviour>(&actor.behaviour))
            lengths[actor.name] = vehicle->length_m;
    ASSERT_GE(lengths.size(), 8u);
    Traffic seen;
    double people_gap_m = 1e9;
    int crossed = 0;
    std::map<std::string, bool> was_north;
    for (TimeNs t = 100 * ns_per_ms; t <= 600 * ns_per_s; t += 100 * ns_per_ms) {
        world->advance_to(t);
        const auto snapshot = world->snapshot(t);
        std::vector<const Instance*> cars, people;
        for (const Instance& mover : snapshot->movers) {
            if (lengths.contains(mover.info->name)) cars.push_back(&mover);
            if (mover.info->object_class == "person") people.push_back(&mover);
        }
        for (const Instance* car : cars) {
            seen.driven_m += glm::length(car->velocity) * 0.1;
            for (const Instance* other : cars) {
                if (other == car) continue;
                // Along the car: the other's middle, its length taken as that of the longest.
                const double gap = gap_to_box(glm::dvec2(other->position), *car, lengths[car->info->name], 1.8) -
                                   lengths[other->info->name] / 2.0;
                const glm::dvec3 side = other->position - car->position;
                const glm::dvec3 ahead =
                    car->orientation * glm::inverse(car->info->heading_from_model) * glm::dvec3(1, 0, 0);
                const bool same_lane = std::abs(ahead.x * side.y - ahead.y * side.x) < 0.5 && std::abs(ahead.y) < 0.1;
                if (same_lane && gap < seen.gap_m) {
                    seen.gap_m = gap;
                    seen.worst = car->info->name + " and " + other->info->name + " at " +
                                 std::to_string(static_cast<double>(t) * 1e-9) + " s";
                }
            }
            for (const Instance* person : people) {
                const double gap =
                    gap_to_box(glm::dvec2(person->position), *car, lengths[car->info->name], 1.8) - person_radius_m;
                seen.person_gap_m = std::min(seen.person_gap_m, gap);
            }
        }
        for (std::size_t i = 0; i < people.size(); ++i) {
            const bool north = people[i]->position.y > 0.0;
            auto [was, is_new] = was_north.emplace(people[i]->info->name, north);
            if (!is_new && was->second != north) ++crossed;
            was->second = north;
            for (std::size_t j = i + 1; j < people.size(); ++j)
                people_gap_m = std::min(
                    people_gap_m, glm::distance(glm::dvec2(people[i]->position), glm::dvec2(people[j]->position)) -
                                      2.0 * person_radius_m);
        }
    }
    std::cout << "nearest: cars " << seen.gap_m << " m (" << seen.worst << "), person and car " << seen.person_gap_m
              << " m, people " << people_gap_m << " m; driven " << seen.driven_m << " m; crossed " << crossed << "\n";
    EXPECT_GT(seen.gap_m, 1.0);
    EXPECT_GT(seen.person_gap_m, 0.3);
    EXPECT_GT(people_gap_m, -0.06);
    EXPECT_GT(seen.driven_m, static_cast<double>(lengths.size()) * 600 * 2.0);
    EXPECT_GT(crossed, 40);
    for (const EventRecord& record : world->take_records())
        for (const std::string& problem : record.errors) ADD_FAILURE() << record.event << ": " << problem;
}

TEST(Street, NobodyWalksThroughAWallOrAParkedCarInTenMinutes) {
    const auto world = coarse("scenes/street.json", 100 * ns_per_ms);
    ASSERT_TRUE(world);
    const WalkArea walls(world->scene().areas.at("walkway"),
                         0.0);  // pavements and crossing, less trees, posts, benches, bins
    std::vector<const ObjectSpec*> parked;
    for (const ObjectSpec& object : world->scene().objects)
        if (object.object_class == "car") parked.push_back(&object);
    ASSERT_GE(parked.size(), 13u);
    double deepest_m = -1e9, parked_gap_m = 1e9, walked_m = 0.0;
    std::string worst;
    for (TimeNs t = 100 * ns_per_ms; t <= 600 * ns_per_s; t += 100 * ns_per_ms) {
        world->advance_to(t);
        const auto snapshot = world->snapshot(t);
        for (const Instance& mover : snapshot->movers) {
            if (mover.info->object_class != "person") continue;
            const glm::dvec2 place(mover.position);
            walked_m += glm::length(mover.velocity) * 0.1;
            if (const double depth = depth_in_walls(walls, place); depth > deepest_m) {
                deepest_m = depth;
                worst = mover.info->name + " at " + std::to_string(static_cast<double>(t) * 1e-9) + " s";
            }
            // A parked car's model has its front along the file's +z, world -y; the longest is 4.9 m, the widest 1.9 m.
            for (const ObjectSpec* car : parked)
                parked_gap_m = std::min(
                    parked_gap_m, gap_to_box(place, car->position, car->orientation * glm::dvec3(0, -1, 0), 4.9, 1.9) -
                                      person_radius_m);
        }
    }
    std::cout << "deepest in a wall " << deepest_m << " m (" << worst << "), nearest parked car " << parked_gap_m
              << " m; walked " << walked_m << " m\n";
    EXPECT_LT(deepest_m, 0.02);
    EXPECT_GT(parked_gap_m, 0.0);
    EXPECT_GT(walked_m, 18 * 600 * 0.3);
}

}  // namespace
}  // namespace camrig::world::scenes_test
