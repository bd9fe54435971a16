#include "core/photo/shadow_sun.h"

#include <cmath>
#include <string>

namespace camrig::photo {
namespace {

/// A shadow that ends nearer than this to its foot says nothing of the sun.
constexpr double min_shadow_m = 0.02;

Result<std::pair<glm::dvec3, double>> direction_of(const PlateView& view, const Shadow& shadow) {
    const auto foot = view.on_ground(shadow.foot_px, shadow.z), tip = view.on_ground(shadow.tip_px, shadow.z);
    if (!foot) return invalid("foot: is over the horizon of the ground");
    if (!tip) return invalid("tip: is over the horizon of the ground");
    const auto seen = view.ray(shadow.top_px);
    if (!seen) return invalid("top: the lens shows nothing there");
    // Of the upright line through the foot, the height nearest to the line of sight.
    const glm::dvec3 along = view.world_from_optical * *seen, from = view.position - *foot;
    const double a = 1.0 - along.z * along.z;
    if (a < 1e-6) return invalid("top: is seen from straight above; use another thing");
    const double height = (from.z - along.z * glm::dot(from, along)) / a;
    if (!(height > min_shadow_m)) return invalid("top: is not above the foot");
    if (glm::distance(*tip, *foot) < min_shadow_m) return invalid("tip: is the foot itself; use a longer shadow");
    return std::pair(glm::normalize(*tip - *foot - glm::dvec3(0, 0, height)), height);
}

}  // namespace

Result<ShadowSun> sun_of_shadow(const PlateView& view, const Shadow& shadow) {
    const auto found = direction_of(view, shadow);
    if (!found) return std::unexpected(found.error());
    ShadowSun sun{found->first, found->second, 0.0};
    double squares = 0.0;
    for (glm::dvec2 Shadow::* const which : {&Shadow::top_px, &Shadow::foot_px, &Shadow::tip_px})
        for (int axis = 0; axis < 2; ++axis) {
            Shadow moved = shadow;
            (moved.*which)[axis] += 0.1;
            const auto other = direction_of(view, moved);
            if (!other) continue;
            const double per_px = glm::length(glm::cross(found->first, other->first)) / 0.1;
            squares += per_px * per_px;
        }
    sun.deviation_rad = std::sqrt(squares);
    return sun;
}

}  // namespace camrig::photo
