#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include <camrig/parameters.h>
#include <glm/glm.hpp>

#include "core/camera/pose.h"

namespace camrig::view {

/// What a camera looks like in the world: lines from where it is to the edge of its picture, `depth_m` before it.
struct Frustum {
    glm::dvec3 apex{0.0};
    glm::dvec3 handle{0.0};  ///< on the viewing direction, depth_m away: what one pulls to turn the camera
    /// Of the picture: top left, top right, bottom right, bottom left; none where the lens shows nothing there.
    std::array<std::optional<glm::dvec3>, 4> corners = {};
    std::vector<std::pair<glm::dvec3, glm::dvec3>> lines = {};  ///< world, metres
};

/// Follows the lens: the edge of a fisheye's picture is drawn as bent as it is. What the client says of a camera
/// suffices; a camera whose lens this program does not know has its apex and handle only.
Frustum frustum_of(const client::CameraState& camera, const camera::Pose& pose, double depth_m);

camera::Pose pose_of(const client::Pose& pose);

}  // namespace camrig::view
