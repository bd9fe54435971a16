#include "core/render/view_transform.h"

#include <cmath>
#include <limits>

namespace camrig::render {

ViewTransform make_view_transform(const camera::Pose& pose, ImageSize size, const camera::Intrinsics& intrinsics,
                                  double near_m, double far_m) {
    ViewTransform view;
    view.eye = pose.position;
    view.optical_from_world = glm::transpose(world_from_optical_rotation(pose));
    view.size = size;
    view.intrinsics = intrinsics;
    view.near_m = near_m;
    // Pixel (u, v) has its centre at window (u + 0.5, v + 0.5): x_ndc = 2 (fx X/Z + cx + 0.5) / width - 1.
    view.x_scale = 2.0 * intrinsics.fx / size.width;
    view.x_shift = (2.0 * intrinsics.cx + 1.0) / size.width - 1.0;
    view.y_scale = 2.0 * intrinsics.fy / size.height;
    view.y_shift = (2.0 * intrinsics.cy + 1.0) / size.height - 1.0;
    // depth = depth_scale + depth_shift / Z.
    if (far_m > near_m) {
        view.depth_scale = -near_m / (far_m - near_m);
        view.depth_shift = near_m * far_m / (far_m - near_m);
    } else {
        view.depth_scale = 0.0;
        view.depth_shift = near_m;
    }
    return view;
}

ViewTransform make_tile_transform(const camera::Pose& pose, const glm::dmat3& tile_from_optical, ImageSize size,
                                  const camera::Intrinsics& intrinsics, double near_m, double far_m) {
    ViewTransform view = make_view_transform(pose, size, intrinsics, near_m, far_m);
    if (tile_from_optical == glm::dmat3(1.0)) return view;
    view.optical_from_world = tile_from_optical * view.optical_from_world;
    view.truth_from_optical = glm::transpose(tile_from_optical);
    return view;
}

glm::dmat4 ViewTransform::optical_from(const glm::dmat4& world_from_local) const {
    glm::dmat4 result(optical_from_world * glm::dmat3(world_from_local));
    result[3] = glm::dvec4(optical_from_world * (glm::dvec3(world_from_local[3]) - eye), 1.0);
    return result;
}

float metres_of_depth(const ViewTransform& view, float depth) {
    if (depth <= 0.0f) return std::numeric_limits<float>::infinity();
    return static_cast<float>(view.depth_shift / (static_cast<double>(depth) - view.depth_scale));
}

Frustum make_frustum(const ViewTransform& view, double far_m) {
    constexpr double slack_px = 1.0;
    const camera::Intrinsics& k = view.intrinsics;
    const double left = -0.5 - slack_px;
    const double top = -0.5 - slack_px;
    const double right = view.size.width - 0.5 + slack_px;
    const double bottom = view.size.height - 0.5 + slack_px;
    const auto side = [](double x, double y, double z) { return glm::dvec4(glm::normalize(glm::dvec3(x, y, z)), 0.0); };
    Frustum frustum;
    frustum.planes[0] = side(k.fx, 0.0, k.cx - left);
    frustum.planes[1] = side(-k.fx, 0.0, right - k.cx);
    frustum.planes[2] = side(0.0, k.fy, k.cy - top);
    frustum.planes[3] = side(0.0, -k.fy, bottom - k.cy);
    frustum.planes[4] = glm::dvec4(0.0, 0.0, 1.0, -view.near_m);
    frustum.planes[5] = glm::dvec4(0.0, 0.0, -1.0, far_m);
    frustum.count = far_m > view.near_m ? 6 : 5;
    return frustum;
}

bool may_be_visible(const Frustum& frustum, const glm::dmat4& optical_from_local, glm::vec3 box_min,
                    glm::vec3 box_max) {
    const glm::dvec3 half = 0.5 * (glm::dvec3(box_max) - glm::dvec3(box_min));
    const glm::dvec3 centre(optical_from_local * glm::dvec4(0.5 * (glm::dvec3(box_max) + glm::dvec3(box_min)), 1.0));
    // Floats carry about 7 digits: a box on a plane must not vanish because of the eighth.
    const double rounding = 1e-6 * (glm::length(centre) + glm::length(half));
    for (int i = 0; i < frustum.count; ++i) {
        const glm::dvec3 normal(frustum.planes[i]);
        const double reach = std::abs(glm::dot(normal, glm::dvec3(optical_from_local[0]))) * half.x +
                             std::abs(glm::dot(normal, glm::dvec3(optical_from_local[1]))) * half.y +
                             std::abs(glm::dot(normal, glm::dvec3(optical_from_local[2]))) * half.z;
        if (glm::dot(normal, centre) + frustum.planes[i].w + reach < -rounding) return false;
    }
    return true;
}

}  // namespace camrig::render
