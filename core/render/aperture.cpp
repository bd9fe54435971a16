#include "core/render/aperture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/gtx/quaternion.hpp>

#include "core/base/portable_math.h"

namespace camrig::render {
std::optional<Aperture> aperture_of(const world::CameraSpec& spec) {
    if (!spec.sensor || !spec.sensor->focus_m) return std::nullopt;
    const double image_m = spec.intrinsics.fx * spec.sensor->pixel_pitch_m;
    const double focal_m = 1.0 / (1.0 / image_m + 1.0 / *spec.sensor->focus_m);
    return Aperture{0.5 * focal_m / spec.sensor->f_number, *spec.sensor->focus_m};
}

double largest_disc_px(const Aperture& aperture, const world::CameraSpec& spec, const frame::Frame& depth) {
    const auto* const metres = reinterpret_cast<const float*>(depth.bytes().data());
    const auto [width, height] = spec.size;
    float nearest = INFINITY, farthest = 0.0f;
    for (std::ptrdiff_t i = 0; i < std::ptrdiff_t{width} * height; ++i) {
        nearest = std::min(nearest, metres[i]);
        farthest = std::max(farthest, metres[i]);
    }
    const auto disc = [&](double d) { return std::abs(1.0 / aperture.focus_m - 1.0 / d); };
    return 2.0 * aperture.radius_m * spec.intrinsics.fx * std::max(disc(nearest), disc(farthest));
}

int count_of_points(double disc_px) {
    if (disc_px < 0.2) return 1;
    return static_cast<int>(std::clamp(std::ceil(14.0 * disc_px), 8.0, double{most_points}));
}

std::vector<glm::dvec2> points_of_opening(int count) {
    const double golden_angle = std::numbers::pi * (3.0 - std::sqrt(5.0));
    std::vector<glm::dvec2> points;
    glm::dvec2 mean(0.0);
    for (int i = 0; i < count; ++i) {
        const double radius = std::sqrt((i + 0.5) / count), angle = golden_angle * i;
        points.emplace_back(radius * portable::cos(angle), radius * portable::sin(angle));
        mean += points.back() / static_cast<double>(count);
    }
    for (glm::dvec2& point : points) point -= mean;
    return points;
}

View seen_from(const View& view, const Aperture& aperture, glm::dvec2 point) {
    const glm::dvec2 at = aperture.radius_m * point;
    View there = view;
    there.pose.position += camera::world_from_optical_rotation(view.pose) * glm::dvec3(at, 0.0);
    if (view.spec->lens.model == camera::LensModel::pinhole) {
        auto shifted = std::make_shared<world::CameraSpec>(*view.spec);
        shifted->intrinsics.cx += shifted->intrinsics.fx * at.x / aperture.focus_m;
        shifted->intrinsics.cy += shifted->intrinsics.fy * at.y / aperture.focus_m;
        there.spec = std::move(shifted);
        return there;
    }
    const glm::dvec3 ahead(1.0, 0.0, 0.0);
    const glm::dvec3 to_focus = glm::normalize(glm::dvec3(aperture.focus_m, at.x, at.y));
    there.pose.orientation = glm::normalize(view.pose.orientation * glm::rotation(ahead, to_focus));
    return there;
}

}  // namespace camrig::render
