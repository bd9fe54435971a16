#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/base/result.h"

namespace camrig::camera {

/// Where a body is and how it is turned: world_from_link. World: right-handed, z up, metres (ROS REP 103).
/// Camera body frame `<name>_link`: x forward, y left, z up. `orientation` is always a unit quaternion.
struct Pose {
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
    friend bool operator==(const Pose&, const Pose&) = default;
};

/// Angles of a pan/tilt head, radians. pan: about world z, counter-clockwise from above, 0 looks along +x.
/// tilt: positive looks up. roll: about the viewing direction, positive is clockwise seen from behind the camera.
struct PanTiltRoll {
    double pan = 0.0;
    double tilt = 0.0;
    double roll = 0.0;
};

/// The orientation that looks from eye to target with the horizon level. Straight up or down (within 1e-9 rad) the
/// image's top points along world +x for down and -x for up, the limit of tilting a camera that looks along +x. Errors:
/// eye and target the same point (closer than 1e-9 m), or not finite.
Result<Pose> pose_look_at(glm::dvec3 eye, glm::dvec3 target);
Result<Pose> pose_from_angles(glm::dvec3 position, PanTiltRoll angles);
/// Normalises; a zero or not finite quaternion is an error.
Result<Pose> pose_from_quaternion(glm::dvec3 position, glm::dquat orientation);
/// Inverse of pose_from_angles: pan and roll in [-pi, pi], tilt in [-pi/2, pi/2]; within 1e-9 rad of a pole pan is
/// chosen with roll = 0. The orientation made of the answer is the given one within 1e-15 (2e-9 at the poles).
PanTiltRoll angles_of(const glm::dquat& orientation);

/// On the way from one pose to another, as a head moves: the position in a straight line, pan (the shorter way round),
/// tilt and roll each at its own rate, so that the horizon stays level between two level poses. share: 0 to 1.
Pose between(const Pose& from, const Pose& to, double share);

/// Positions further out than this are refused (1e10 m): beyond it doubles cannot hold a micrometre.
inline constexpr double max_coordinate_m = 1e10;

/// Fixed rotation between the body and the optical frame (z forward, x right, y down; REP 103/105):
/// v_link = link_from_optical() * v_optical.
glm::dmat3 link_from_optical();

/// Rotation of the optical frame in the world: world_from_optical = R(orientation) * link_from_optical().
glm::dmat3 world_from_optical_rotation(const Pose& pose);

}  // namespace camrig::camera
