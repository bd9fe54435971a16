#include "core/photo/plate_view.h"

namespace camrig::photo {

std::optional<glm::dvec2> PlateView::project(const glm::dvec3& point) const {
    const auto ideal = lens.ideal_from_direction(glm::transpose(world_from_optical) * (point - position));
    if (!ideal || !lens.contains(*ideal)) return std::nullopt;
    const glm::dvec2 at = lens.distort(*ideal);
    return glm::dvec2{k.fx * at.x + k.cx, k.fy * at.y + k.cy};
}

std::optional<glm::dvec3> PlateView::ray(glm::dvec2 pixel) const {
    const auto ideal = lens.undistort({(pixel.x - k.cx) / k.fx, (pixel.y - k.cy) / k.fy});
    if (!ideal) return std::nullopt;
    return lens.direction_from_ideal(*ideal);
}

std::optional<glm::dvec3> PlateView::on_ground(glm::dvec2 pixel, double z) const {
    const auto seen = ray(pixel);
    if (!seen) return std::nullopt;
    const glm::dvec3 along = world_from_optical * *seen;
    const double way = (z - position.z) / along.z;
    if (!(way > 0.0) || way > 1e6) return std::nullopt;
    return position + way * along;
}

camera::Pose pose_of(const PlateView& view) {
    const glm::dmat3 world_from_link = view.world_from_optical * glm::transpose(camera::link_from_optical());
    return {view.position, glm::normalize(glm::quat_cast(world_from_link))};
}

}  // namespace camrig::photo
