#include "core/camera/pose.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/base/portable_math.h"

namespace camrig::camera {
namespace {

/// Closer together than this, eye and target are the same point.
constexpr double min_look_at_distance_m = 1e-9;
/// Within this angle of straight up or down a viewing direction has no heading.
constexpr double pole_rad = 1e-9;
/// Larger angles are a mistake of units or a runaway integrator, and sine and cosine of them mean little.
constexpr double max_angle_rad = 1e6;
/// A quaternion whose largest part is below this is the zero quaternion after underflow, not a direction.
constexpr double min_quaternion_part = 1e-150;

Result<void> check_position(const char* what, const glm::dvec3& p) {
    for (int i = 0; i < 3; ++i) {
        if (!std::isfinite(p[i]) || std::abs(p[i]) > max_coordinate_m) {
            return error(ErrorKind::invalid_argument,
                         std::string(what) + ": coordinates must be finite and within 1e10 m of the origin");
        }
    }
    return {};
}

/// Rotation about z (pan), then down about the new y (-tilt), then about the new x (roll).
glm::dquat from_angles(const PanTiltRoll& angles) {
    const auto about = [](double angle, glm::dvec3 axis) {
        return glm::dquat(portable::cos(0.5 * angle), portable::sin(0.5 * angle) * axis);
    };
    const glm::dquat q = about(angles.pan, {0, 0, 1}) * about(-angles.tilt, {0, 1, 0}) * about(angles.roll, {1, 0, 0});
    return glm::normalize(q);
}

}  // namespace

Result<Pose> pose_look_at(glm::dvec3 eye, glm::dvec3 target) {
    if (auto good = check_position("position", eye); !good) return std::unexpected(good.error());
    if (auto good = check_position("look_at", target); !good) return std::unexpected(good.error());
    const glm::dvec3 forward = target - eye;
    const double distance = glm::length(forward);
    if (distance < min_look_at_distance_m) {
        return error(ErrorKind::invalid_argument,
                     "look_at: is the same point as position; give a point at least 1e-9 m away, or angles");
    }
    const double horizontal = glm::length(glm::dvec2(forward));
    PanTiltRoll angles;
    angles.tilt = portable::atan2(forward.z, horizontal);
    // Straight up or down there is no heading; 0 is the limit of a camera that looks along +x and is tilted.
    if (horizontal > pole_rad * distance) angles.pan = portable::atan2(forward.y, forward.x);
    return Pose{eye, from_angles(angles)};
}

Result<Pose> pose_from_angles(glm::dvec3 position, PanTiltRoll angles) {
    if (auto good = check_position("position", position); !good) return std::unexpected(good.error());
    const auto bad = [](double angle) { return !(std::abs(angle) <= max_angle_rad); };
    if (bad(angles.pan) || bad(angles.tilt) || bad(angles.roll))
        return error(ErrorKind::invalid_argument, "pan_deg: pan, tilt and roll must be angles of at most 1e6 rad");
    return Pose{position, from_angles(angles)};
}

Result<Pose> pose_from_quaternion(glm::dvec3 position, glm::dquat orientation) {
    if (auto good = check_position("position", position); !good) return std::unexpected(good.error());
    // Scaled by its largest part first, so that neither huge nor denormal parts overflow or vanish when squared.
    double largest = 0.0;
    for (int i = 0; i < 4; ++i) {
        if (!std::isfinite(orientation[i]))
            return error(ErrorKind::invalid_argument, "orientation: [x, y, z, w] must be finite");
        largest = std::max(largest, std::abs(orientation[i]));
    }
    if (largest < min_quaternion_part)
        return error(ErrorKind::invalid_argument,
                     "orientation: a zero quaternion is no rotation; [0, 0, 0, 1] is none at all");
    return Pose{position, glm::normalize(orientation * (1.0 / largest))};
}

PanTiltRoll angles_of(const glm::dquat& orientation) {
    const glm::dmat3 r = glm::mat3_cast(orientation);  // columns: where x, y, z of the body point
    const glm::dvec3 x = r[0], y = r[1], z = r[2];
    PanTiltRoll angles;
    const double horizontal = glm::length(glm::dvec2(x));
    angles.tilt = portable::atan2(x.z, horizontal);
    if (horizontal <= pole_rad) {
        angles.pan = portable::atan2(-y.x, y.y);
        return angles;
    }
    angles.pan = portable::atan2(x.y, x.x);
    // Roll is what is left when the pan just found is taken back. Near a pole pan itself is uncertain; read off this
    // way (and not from y.z and z.z, which vanish there) roll makes up for it, and the three together stay exact.
    const double s = portable::sin(angles.pan), c = portable::cos(angles.pan);
    angles.roll = portable::atan2(s * z.x - c * z.y, c * y.y - s * y.x);
    return angles;
}

Pose between(const Pose& from, const Pose& to, double share) {
    Pose pose{from.position + (to.position - from.position) * share, from.orientation};
    if (from.orientation == to.orientation) return pose;
    const PanTiltRoll a = angles_of(from.orientation), b = angles_of(to.orientation);
    const auto turned = [share](double begin, double end) {
        return begin + std::remainder(end - begin, 2.0 * std::numbers::pi) * share;
    };
    pose.orientation = from_angles({turned(a.pan, b.pan), turned(a.tilt, b.tilt), turned(a.roll, b.roll)});
    return pose;
}

glm::dmat3 link_from_optical() {
    // Columns: optical x (right) is link -y, optical y (down) is link -z, optical z (forward) is link x.
    return glm::dmat3(glm::dvec3(0, -1, 0), glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0));
}

glm::dmat3 world_from_optical_rotation(const Pose& pose) {
    return glm::mat3_cast(pose.orientation) * link_from_optical();
}

}  // namespace camrig::camera
