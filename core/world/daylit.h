#pragma once

#include <vector>

#include "core/world/model.h"
#include "core/world/snapshot.h"

namespace camrig::world {

/// The directional light that daylight makes.
inline constexpr const char* sun_name = "sun";
/// Illuminance where white is drawn as white, in an environment with daylight that says nothing else.
inline constexpr double daylight_lux = 100e3;

/// Of an environment with daylight: makes the ambient light, the background, and the light `sun`, which comes if it is
/// not there.
void apply_daylight(Environment& environment, std::vector<Light>& lights);

/// The sky of an environment with daylight, instead of the model of a SkyShape.
ModelRef daylit_sky(const Environment& environment, double radius_m);
/// All objects that are skies.
void show_sky(StaticSet& statics);

}  // namespace camrig::world
