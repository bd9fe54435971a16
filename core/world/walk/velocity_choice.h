#pragma once

#include <span>

#include <glm/glm.hpp>

namespace camrig::world {

/// The velocities v with normal . v >= offset; normal is a unit vector.
struct HalfPlane {
    glm::dvec2 normal{1.0, 0.0};
    double offset = 0.0;
};

/// Another disc that moves, seen from the one that chooses.
struct Encounter {
    glm::dvec2 position{0.0};  ///< of the other, from here
    glm::dvec2 velocity{0.0};  ///< of the other
    double radius = 0.0;       ///< of both together
    double share = 0.5;        ///< of the avoiding that is done here: 1/2 when the other does the same, else 1
};

/// The velocities that do not lead to a collision within `horizon_s`, as one half-plane ("optimal reciprocal collision
/// avoidance", ORCA: van den Berg, Guy, Lin, Manocha, "Reciprocal n-body collision avoidance", ISRR 2011, section 4).
/// Two that overlap already part within `overlap_s`.
HalfPlane avoid(const Encounter& other, const glm::dvec2& own_velocity, double horizon_s, double overlap_s);

/// The velocities with which a disc of `radius` does not reach a wall within `horizon_s`. `to_wall`: from here to the
/// wall's nearest point. A wall that is convex lies behind the tangent there, so this is safe, not only near the point.
HalfPlane keep_off(const glm::dvec2& to_wall, double radius, double horizon_s);

/// The velocity nearest to `wanted`, at most `max_speed` fast, that obeys all half-planes. Where there is none: of
/// those that obey the first `hard` of them, the one that breaks the worst of the others least (ibid., section 5).
/// Where even the first `hard` contradict each other, all are treated as the others. Linear programs of two variables,
/// each constraint added in its turn: the answer depends on the order only where there are several.
glm::dvec2 choose_velocity(std::span<const HalfPlane> planes, std::size_t hard, const glm::dvec2& wanted,
                           double max_speed);

}  // namespace camrig::world
