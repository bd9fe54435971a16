#pragma once

#include <glm/glm.hpp>

#include "core/camera/pose.h"

namespace camrig::view {

/// Where the person at the window is, and how they look: a camera without roll that is steered like in a game.
struct FlyCamera {
    glm::dvec3 position{0.0};
    double pan_rad = 0;   ///< as PanTiltRoll
    double tilt_rad = 0;  ///< within +-max_tilt_rad: straight up and down have no left

    friend bool operator==(const FlyCamera&, const FlyCamera&) = default;

    static constexpr double max_tilt_rad = 1.55;

    camera::Pose pose() const;
    /// Where `pose` is and looks, without its roll.
    static FlyCamera at(const camera::Pose& pose);

    /// Goes along the viewing direction, to the left, and up along world z; metres.
    void go(double ahead_m, double left_m, double up_m);
    /// Turns so that what was under the mouse follows it: `pixels` of motion, `focal_px` pixels to a radian at the
    /// middle.
    void drag(glm::dvec2 pixels, double focal_px);
};

}  // namespace camrig::view
