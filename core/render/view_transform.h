#pragma once

#include <array>

#include <glm/glm.hpp>

#include "core/base/image_size.h"
#include "core/camera/intrinsics.h"
#include "core/camera/pose.h"

namespace camrig::render {

/// The linear part of one rasterised picture: where the camera stands and how points become pixels.
///
/// Everything is camera-relative and in double until the last moment: float sees only differences to the eye, so the
/// picture is the same at the origin and a million kilometres away from it (as far as doubles can hold the scene).
/// Clip space: x and y as GL has them with y = -1 at the *top* of the image, so that row 0 in memory is the top row and
/// nothing is ever flipped; depth is reversed, 1 at the near plane and 0 at infinity, which gives float depth the same
/// relative precision everywhere.
struct ViewTransform {
    glm::dvec3 eye{0.0};
    glm::dmat3 optical_from_world{1.0};
    /// The camera's own optical frame from this picture's; they differ only for the faces of a cube.
    glm::dmat3 truth_from_optical{1.0};
    ImageSize size;
    camera::Intrinsics intrinsics;
    double near_m = 0.05;
    /// clip = (x_scale * X + x_shift * Z, y_scale * Y + y_shift * Z, depth_scale * Z + depth_shift, Z)
    double x_scale = 1.0;
    double x_shift = 0.0;
    double y_scale = 1.0;
    double y_shift = 0.0;
    double depth_scale = 0.0;
    double depth_shift = 0.0;

    /// Optical-frame transform of something placed in the world: rotation in the upper left, exact difference to the
    /// eye in the translation.
    glm::dmat4 optical_from(const glm::dmat4& world_from_local) const;
};

/// far_m = 0: infinite.
ViewTransform make_view_transform(const camera::Pose& pose, ImageSize size, const camera::Intrinsics& intrinsics,
                                  double near_m, double far_m);

/// The same eye looking through a plane turned against the camera's.
ViewTransform make_tile_transform(const camera::Pose& pose, const glm::dmat3& tile_from_optical, ImageSize size,
                                  const camera::Intrinsics& intrinsics, double near_m, double far_m);

/// Metres along the optical axis of a depth buffer value; +inf where nothing was drawn.
float metres_of_depth(const ViewTransform& view, float depth);

/// Planes (normal, offset) in the optical frame, pointing inwards: n . p + d >= 0 inside. One pixel of slack on each
/// side keeps points, lines and rounding on the safe side.
struct Frustum {
    std::array<glm::dvec4, 6> planes{};
    int count = 0;
};
Frustum make_frustum(const ViewTransform& view, double far_m);

/// False only if the box, placed by `optical_from_local`, certainly touches no pixel.
bool may_be_visible(const Frustum& frustum, const glm::dmat4& optical_from_local, glm::vec3 box_min, glm::vec3 box_max);

}  // namespace camrig::render
