#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "core/camera/intrinsics.h"
#include "core/camera/lens_map.h"
#include "core/camera/pose.h"

namespace camrig::photo {

/// A camera in the world as the search moves it about: cheap to make, nothing is checked.
struct PlateView {
    camera::Intrinsics k;
    camera::LensMap lens;
    glm::dmat3 world_from_optical{1.0};
    glm::dvec3 position{0.0};

    /// None behind the camera and beyond the fold of the lens.
    std::optional<glm::dvec2> project(const glm::dvec3& point) const;
    /// Unit direction in the optical frame; none where the lens shows nothing.
    std::optional<glm::dvec3> ray(glm::dvec2 pixel) const;
    /// Where a pixel sees level ground; none over its horizon.
    std::optional<glm::dvec3> on_ground(glm::dvec2 pixel, double z) const;
};

camera::Pose pose_of(const PlateView& view);

}  // namespace camrig::photo
