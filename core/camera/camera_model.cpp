#include "core/camera/camera_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/number_text.h"

namespace camrig::camera {

Result<CameraModel> CameraModel::create(ImageSize size, const Intrinsics& intrinsics, const Lens& lens) {
    if (size.width > max_image_size.width || size.height > max_image_size.height)
        return error(ErrorKind::invalid_argument, "size: " + size.to_string() + " is larger than 8192x8192");
    if (auto good = check_intrinsics(size, intrinsics); !good) return std::unexpected(good.error());
    auto map = LensMap::create(lens);
    if (!map) return std::unexpected(map.error());
    CameraModel camera;
    camera.size_ = size;
    camera.k_ = intrinsics;
    camera.lens_ = *map;
    if (!camera.survey_edges()) {
        return error(ErrorKind::invalid_argument, "lens: no pixel of the " + size.to_string() +
                                                      " picture is inside the lens's valid " +
                                                      number_text(map->valid_angle() * 180.0 / std::numbers::pi) +
                                                      " deg; check that size and intrinsics belong to this lens");
    }
    return camera;
}

/// Walks the outer edges of the picture. Valid pixels are the image of a disc about the axis: if every edge point is
/// valid so is what lies between, and the angle to the axis is largest on the edge. False if nothing is valid.
bool CameraModel::survey_edges() {
    const double right = size_.width - 0.5, bottom = size_.height - 0.5;
    bool some_valid = false;
    const auto visit = [&](double x, double y) {
        const auto ideal = lens_.undistort(distorted_of({x, y}));
        if (!ideal) {
            every_pixel_valid_ = false;
            return;
        }
        some_valid = true;
        const glm::dvec3 ray = lens_.direction_from_ideal(*ideal);
        max_field_angle_ = std::max(max_field_angle_, std::atan2(std::hypot(ray.x, ray.y), ray.z));
    };
    // Straight edges are farthest from the axis where they end.
    const int across = lens_.is_identity() ? size_.width : 1, down = lens_.is_identity() ? size_.height : 1;
    for (int x = 0; x <= size_.width; x += across) {
        visit(x - 0.5, -0.5);
        visit(x - 0.5, bottom);
    }
    for (int y = 0; y <= size_.height; y += down) {
        visit(-0.5, y - 0.5);
        visit(right, y - 0.5);
    }
    if (!every_pixel_valid_) max_field_angle_ = lens_.valid_angle();
    return some_valid || in_image({k_.cx, k_.cy});
}

std::optional<glm::dvec2> CameraModel::project(const glm::dvec3& point) const {
    const auto ideal = lens_.ideal_from_direction(point);
    if (!ideal || !lens_.contains(*ideal)) return std::nullopt;
    const glm::dvec2 distorted = lens_.distort(*ideal);
    return glm::dvec2(k_.fx * distorted.x + k_.cx, k_.fy * distorted.y + k_.cy);
}

std::optional<glm::dvec3> CameraModel::ray(glm::dvec2 pixel) const {
    const auto ideal = lens_.undistort(distorted_of(pixel));
    if (!ideal) return std::nullopt;
    return lens_.direction_from_ideal(*ideal);
}

}  // namespace camrig::camera
