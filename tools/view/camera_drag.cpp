#include "tools/view/camera_drag.h"

#include <algorithm>
#include <utility>

namespace camrig::view {

namespace {

/// Seen from behind, a camera's handle lies on its body: it is the body then that one means.
constexpr double body_advantage_px = 3;

}  // namespace

const GripPoint* nearest_grip(std::span<const GripPoint> grips, glm::dvec2 mouse, double reach_px) {
    const GripPoint* nearest = nullptr;
    for (const GripPoint& one : grips) {
        const double distance = glm::length(one.screen - mouse) - (one.grip == Grip::handle ? 0 : body_advantage_px);
        if (distance > reach_px) continue;
        reach_px = distance;
        nearest = &one;
    }
    return nearest;
}

CameraDrag::CameraDrag(std::string camera, Grip grip, const camera::Pose& start, const Ray& ray, double handle_m)
    : camera_(std::move(camera)),
      grip_(grip),
      start_(start),
      present_(start),
      handle_m_(handle_m),
      roll_rad_(camera::angles_of(start.orientation).roll) {
    if (grip_ == Grip::body) {
        if (const auto point = on_plane(ray)) offset_ = start_.position - *point;
    } else if (grip_ == Grip::lift) {
        offset_.z = start_.position.z - height_beside(ray, start_.position);
    }
}

std::optional<glm::dvec3> CameraDrag::on_plane(const Ray& ray) const {
    const auto point = meet_plane(ray, start_.position.z);
    if (!point || glm::length(*point - ray.origin) > max_distance_m) return std::nullopt;
    return point;
}

const camera::Pose& CameraDrag::to(const Ray& ray) {
    if (grip_ == Grip::body) {
        if (const auto point = on_plane(ray)) present_.position = *point + offset_;
    } else if (grip_ == Grip::lift) {
        present_.position.z =
            std::clamp(height_beside(ray, start_.position) + offset_.z, -max_distance_m, max_distance_m);
    } else {
        const glm::dvec3 ahead = glm::mat3_cast(present_.orientation) * glm::dvec3(handle_m_, 0, 0);
        const glm::dvec3 handle = meet_sphere(ray, present_.position, handle_m_, present_.position + ahead);
        if (auto turned = camera::pose_look_at(present_.position, handle)) {
            camera::PanTiltRoll angles = camera::angles_of(turned->orientation);
            angles.roll = roll_rad_;
            if (auto rolled = pose_from_angles(present_.position, angles)) present_ = *rolled;
        }
    }
    return present_;
}

}  // namespace camrig::view
