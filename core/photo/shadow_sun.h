#pragma once

#include "core/base/result.h"
#include "core/photo/plate_view.h"

namespace camrig::photo {

/// A thing that stands upright on level ground, and the tip of its shadow there.
struct Shadow {
    glm::dvec2 top_px{0.0}, foot_px{0.0}, tip_px{0.0};
    double z = 0.0;
};
struct ShadowSun {
    glm::dvec3 light_direction{0.0};
    double height_m = 0.0;       ///< of the thing
    double deviation_rad = 0.0;  ///< of the direction, for a click error of one pixel
};
/// Errors: over the horizon, no shadow to speak of, a tip that lies before the thing as seen from the sun.
Result<ShadowSun> sun_of_shadow(const PlateView& view, const Shadow& shadow);

}  // namespace camrig::photo
