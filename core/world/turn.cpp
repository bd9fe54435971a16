#include "core/world/turn.h"

#include <cmath>
#include <numbers>

#include "core/base/portable_math.h"

namespace camrig::world {

double angle_to(double from_rad, double to_rad) {
    return std::remainder(to_rad - from_rad, 2.0 * std::numbers::pi);
}

double yaw_of(const glm::dvec2& direction) {
    return portable::atan2(direction.y, direction.x);
}

double yaw_of(const glm::dquat& orientation) {
    return yaw_of(glm::dvec2(orientation * glm::dvec3(1.0, 0.0, 0.0)));
}

glm::dquat turned_to(double yaw_rad) {
    return {portable::cos(0.5 * yaw_rad), 0.0, 0.0, portable::sin(0.5 * yaw_rad)};
}

}  // namespace camrig::world
