#include "tools/view/sight.h"

#include <algorithm>
#include <cmath>

namespace camrig::view {

Sight::Sight(const camera::Pose& pose, double vfov_rad, glm::dvec2 origin, glm::dvec2 extent)
    : position_(pose.position),
      world_from_optical_(world_from_optical_rotation(pose)),
      focal_px_(extent.y / 2 / std::tan(vfov_rad / 2)),
      middle_(origin + extent / 2.0) {}

glm::dvec2 Sight::screen_of(const glm::dvec3& in_optical) const {
    return middle_ + glm::dvec2(in_optical) * (focal_px_ / in_optical.z);
}

std::optional<glm::dvec2> Sight::project(const glm::dvec3& point) const {
    const glm::dvec3 seen = glm::transpose(world_from_optical_) * (point - position_);
    if (!(seen.z >= near_m)) return std::nullopt;
    return screen_of(seen);
}

std::optional<std::pair<glm::dvec2, glm::dvec2>> Sight::project(const glm::dvec3& a, const glm::dvec3& b) const {
    const glm::dmat3 optical_from_world = glm::transpose(world_from_optical_);
    glm::dvec3 from = optical_from_world * (a - position_);
    glm::dvec3 to = optical_from_world * (b - position_);
    if (!(from.z >= near_m) && !(to.z >= near_m)) return std::nullopt;
    const auto cut = [&](glm::dvec3& behind, const glm::dvec3& before) {
        behind = glm::mix(behind, before, (near_m - behind.z) / (before.z - behind.z));
    };
    if (from.z < near_m) cut(from, to);
    if (to.z < near_m) cut(to, from);
    return std::pair{screen_of(from), screen_of(to)};
}

Ray Sight::ray(glm::dvec2 screen) const {
    const glm::dvec3 in_optical((screen - middle_) / focal_px_, 1.0);
    return {position_, glm::normalize(world_from_optical_ * in_optical)};
}

std::optional<glm::dvec3> meet_plane(const Ray& ray, double height_m) {
    const double along = (height_m - ray.origin.z) / ray.direction.z;
    if (!std::isfinite(along) || along <= 0) return std::nullopt;
    glm::dvec3 point = ray.origin + along * ray.direction;
    point.z = height_m;
    return point;
}

double height_beside(const Ray& ray, const glm::dvec3& point) {
    // The nearest points of the ray and of the vertical through `point`: both seen from above they meet there.
    const glm::dvec2 flat(ray.direction);
    const double length2 = glm::dot(flat, flat);
    if (length2 < 1e-12) return point.z;  // straight up or down: every height is as near
    const double along = std::max(0.0, glm::dot(glm::dvec2(point - ray.origin), flat) / length2);
    return ray.origin.z + along * ray.direction.z;
}

glm::dvec3 meet_sphere(const Ray& ray, const glm::dvec3& centre, double distance_m, const glm::dvec3& present) {
    const double nearest_along = glm::dot(centre - ray.origin, ray.direction);
    const glm::dvec3 nearest = ray.origin + nearest_along * ray.direction;
    const double miss = glm::length(nearest - centre);
    if (miss >= distance_m) return centre + (nearest - centre) * (distance_m / miss);
    const double half_chord = std::sqrt(distance_m * distance_m - miss * miss);
    const glm::dvec3 front = nearest - half_chord * ray.direction;
    const glm::dvec3 back = nearest + half_chord * ray.direction;
    // A person pulls on what they see: what lies behind the eye cannot be meant.
    const bool front_is_seen = nearest_along - half_chord > 0;
    if (!front_is_seen) return back;
    return glm::length(front - present) <= glm::length(back - present) ? front : back;
}

}  // namespace camrig::view
