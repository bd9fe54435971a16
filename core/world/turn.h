#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

/// Turns about the vertical, in radians, counter-clockwise from +x. The same bits on every machine.
namespace camrig::world {

/// The turn from `from` to `to`, in [-pi, pi].
double angle_to(double from_rad, double to_rad);
/// Of a direction in the plane.
double yaw_of(const glm::dvec2& direction);
/// Of the front (+x) of an actor.
double yaw_of(const glm::dquat& orientation);
glm::dquat turned_to(double yaw_rad);

}  // namespace camrig::world
