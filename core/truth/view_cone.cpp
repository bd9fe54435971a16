#include "core/truth/view_cone.h"

#include <algorithm>
#include <cmath>

namespace camrig::truth {
namespace {

/// Pictures are rounded to pixels and, behind a lens, to those of a source picture.
constexpr double margin_px = 4.0;
constexpr double margin_rad = 0.01;

}  // namespace

ViewCone::ViewCone(const camera::CameraModel& camera)
    : half_angle_(camera.max_field_angle() + margin_rad +
                  margin_px / std::min(camera.intrinsics().fx, camera.intrinsics().fy)) {}

bool ViewCone::may_meet(const glm::dvec3& center, double radius) const {
    if (radius < 0.0) return false;
    const double distance = glm::length(center);
    if (!(distance > radius)) return true;
    const double off_axis = std::atan2(std::hypot(center.x, center.y), center.z);
    return off_axis - std::asin(radius / distance) <= half_angle_;
}

}  // namespace camrig::truth
