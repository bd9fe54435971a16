#pragma once

#include <string_view>

#include <glm/glm.hpp>

#include "core/base/result.h"

namespace camrig::daylight {

/// Where the sun stands, radians: azimuth from north through east, elevation over the horizon.
struct SunPlace {
    double azimuth = 0.0, elevation = 0.0;
};

/// Seconds since 1970-01-01 UTC of "2026-06-21T14:30:00Z", with an offset "+02:00" or "Z"; seconds may be left out.
Result<double> read_instant(std::string_view text);

/// Of an instant and a place on Earth (degrees, north and east positive), without the refraction of the air. NOAA's
/// solar calculator: Meeus, Astronomical Algorithms, 2nd edition, chapters 25 and 28; within 0.02 degrees of
/// ephemerides from 1950 to 2050, refraction (half a degree at the horizon, a hundredth at 60 degrees) aside.
SunPlace sun_at(double unix_s, double latitude_deg, double longitude_deg);

/// The way its light travels. `north`: direction of north in the world, from x counter-clockwise, radians.
glm::dvec3 light_direction(const SunPlace& sun, double north);
/// The inverse.
SunPlace sun_of(const glm::dvec3& light_direction, double north);

}  // namespace camrig::daylight
