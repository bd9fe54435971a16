#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "core/world/walk/walk_area.h"
#include "core/world/world.h"

namespace camrig::world::world_test {

/// How deep two bodies, taken as discs of a person's radius, were ever inside of each other, and a body in a wall.
struct Depths {
    double bodies_m = 0.0;
    double walls_m = 0.0;
    double walked_m = 0.0;  ///< by all together
    std::string worst;
};

/// How far a person's disc reaches into the walls of an area; negative: how far it stays off them.
inline double depth_in_walls(const WalkArea& walls, glm::dvec2 place) {
    const double distance = walls.wall_distance(place);
    return person_radius_m + (walls.contains(place) ? -distance : distance);
}

/// `seated`: people whose names begin so belong to the furniture.
inline Depths watch(World& world, const Area& area, TimeNs duration_ns, std::string_view seated = "/") {
    const WalkArea walls(area, 0.0);
    Depths depths;
    const TimeNs every_ns = world.scene().step_ns;
    for (TimeNs t = every_ns; t <= duration_ns; t += every_ns) {
        world.advance_to(t);
        const auto snapshot = world.snapshot(t);
        std::vector<const Instance*> people;
        for (const Instance& mover : snapshot->movers)
            if (mover.info->object_class == "person" && !mover.info->name.starts_with(seated)) people.push_back(&mover);
        for (std::size_t i = 0; i < people.size(); ++i) {
            const glm::dvec2 a(people[i]->position);
            depths.walked_m += glm::length(people[i]->velocity) * static_cast<double>(every_ns) * 1e-9;
            depths.walls_m = std::max(depths.walls_m, depth_in_walls(walls, a));
            for (std::size_t j = i + 1; j < people.size(); ++j) {
                const double depth = 2.0 * person_radius_m - glm::distance(a, glm::dvec2(people[j]->position));
                if (depth <= depths.bodies_m) continue;
                depths.bodies_m = depth;
                depths.worst = people[i]->info->name + " and " + people[j]->info->name + " at " +
                               std::to_string(static_cast<double>(t) * 1e-9) + " s";
            }
        }
    }
    return depths;
}

}  // namespace camrig::world::world_test
