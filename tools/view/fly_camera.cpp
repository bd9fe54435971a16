#include "tools/view/fly_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace camrig::view {

camera::Pose FlyCamera::pose() const {
    auto pose = camera::pose_from_angles(position, {.pan = pan_rad, .tilt = tilt_rad, .roll = 0});
    return pose ? *pose : camera::Pose{};  // refused are positions out of the world only, and go() stays in it
}

FlyCamera FlyCamera::at(const camera::Pose& pose) {
    const camera::PanTiltRoll angles = camera::angles_of(pose.orientation);
    return {pose.position, angles.pan, std::clamp(angles.tilt, -max_tilt_rad, max_tilt_rad)};
}

void FlyCamera::go(double ahead_m, double left_m, double up_m) {
    const glm::dmat3 world_from_link = glm::mat3_cast(pose().orientation);
    position += world_from_link * glm::dvec3(ahead_m, left_m, 0) + glm::dvec3(0, 0, up_m);
    position = glm::clamp(position, glm::dvec3(-1e6), glm::dvec3(1e6));
}

void FlyCamera::drag(glm::dvec2 pixels, double focal_px) {
    pan_rad = std::remainder(pan_rad + pixels.x / focal_px, 2 * std::numbers::pi);
    tilt_rad = std::clamp(tilt_rad + pixels.y / focal_px, -max_tilt_rad, max_tilt_rad);
}

}  // namespace camrig::view
