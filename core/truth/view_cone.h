#pragma once

#include <glm/glm.hpp>

#include "core/camera/camera_model.h"

namespace camrig::truth {

/// All directions that a camera's picture can show, and a little more: a cone about the optical axis. What lies outside
/// of it shows on no pixel, whatever rasterisers and lenses round.
class ViewCone {
public:
    explicit ViewCone(const camera::CameraModel& camera);
    /// Whether it may meet a ball in the optical frame; true when the camera is inside of the ball.
    bool may_meet(const glm::dvec3& center, double radius) const;

private:
    double half_angle_;
};

}  // namespace camrig::truth
