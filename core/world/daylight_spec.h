#pragma once

#include <numbers>
#include <optional>
#include <string>

#include <glm/glm.hpp>

namespace camrig::world {

/// The sun over a place, and the air before it (core/daylight): `daylight` of an environment.
struct DaylightSpec {
    std::optional<double> azimuth_rad, elevation_rad;  ///< where the sun stands
    std::string time;                                  ///< or when and where it is (read_instant); empty: the angles
    double latitude_deg = 0.0, longitude_deg = 0.0;
    double north_rad = 0.5 * std::numbers::pi;  ///< in the world, from x counter-clockwise
    double turbidity = 3.0;
    double overcast = 0.0;
    glm::vec3 ground{0.25f};      ///< what it reflects
    std::optional<float> clouds;  ///< share of the sky that they are; nullopt: as `overcast`
    friend bool operator==(const DaylightSpec&, const DaylightSpec&) = default;
};

}  // namespace camrig::world
