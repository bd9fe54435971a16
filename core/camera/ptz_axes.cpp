#include "core/camera/ptz_axes.h"

#include <cmath>

#include <glm/trigonometric.hpp>

#include "core/base/portable_math.h"

namespace camrig::camera {
namespace {

glm::dquat about(const glm::dvec3& axis, double degrees) {
    const double half = 0.5 * glm::radians(degrees);
    return glm::dquat(portable::cos(half), portable::sin(half) * axis);
}

}  // namespace

bool is_over(const Pose& base, const PtzPosition& head) {
    constexpr double straight_deg = 90.0 + 1e-6;  // what rounding adds to straight up or down is not past it
    return std::abs(glm::degrees(angles_of(base.orientation).tilt) + head.tilt_deg) > straight_deg;
}

Pose turned_by(const Pose& base, const PtzPosition& head, bool is_turned_over) {
    if (head.pan_deg == 0.0 && head.tilt_deg == 0.0) return base;
    const double roll = glm::degrees(angles_of(base.orientation).roll);
    const glm::dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    // base is pan * tilt * roll: the roll is taken off, the tilt added and the roll put on again.
    const double over = is_turned_over ? 180.0 : 0.0;
    const glm::dquat tilted = base.orientation * about(x, -roll) * about(y, -head.tilt_deg) * about(x, roll + over);
    return {base.position, glm::normalize(about(z, head.pan_deg) * tilted)};
}

PtzPosition aimed_along(const Pose& base, const glm::dvec3& direction, const PtzPosition& now) {
    const PanTiltRoll rest = angles_of(base.orientation);
    const double level = glm::length(glm::dvec2(direction));
    double pan = glm::degrees(portable::atan2(direction.y, direction.x) - rest.pan);
    double tilt = glm::degrees(portable::atan2(direction.z, level) - rest.tilt);
    if (is_over(base, now)) pan += 180.0, tilt = 180.0 - tilt - 2.0 * glm::degrees(rest.tilt);
    if (level < 1e-9 * glm::length(direction)) pan = now.pan_deg;
    return {std::remainder(pan, 360.0), std::remainder(tilt, 360.0), now.zoom};
}

}  // namespace camrig::camera
