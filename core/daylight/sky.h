#pragma once

#include <array>

#include <glm/glm.hpp>

/// What light sun and sky give, by where the sun stands: illuminances in lux, colours in linear sRGB in a scene whose
/// white is 6500 K.
///
/// Level ground under a clear sky, down to astronomical twilight: Janiczek and DeYoung, U.S. Naval Observatory Circular
/// 171, 1987. What of it comes straight from the sun: Linke's turbidity, Kasten's optical depth of clean dry air (Solar
/// Energy 56, 1996) and the air mass of Kasten and Young (1989). How the rest is spread over the sky, and its colour:
/// Preetham, Shirley and Smits, SIGGRAPH 1999. Under an overcast sky: Krochmann and Seidl (Lighting Research and
/// Technology 6, 1974), spread as CIE S 011 type 16 has it. No moon and no town: below 18 degrees under the horizon
/// 2 mlx are left, of stars and airglow. Any thread; the same bits on every machine.
namespace camrig::daylight {

struct Air {
    double turbidity = 3.0;  ///< Linke's, 2 (very clean) to 10 (haze)
    double overcast = 0.0;   ///< share of the time that clouds hide the sun, and of the sky that they are; 0 to 1
};

class Sky {
public:
    /// to_sun: unit, z up; below the horizon it is twilight or night.
    Sky(const glm::dvec3& to_sun, const Air& air);

    /// On a surface that faces the sun, of the sun alone.
    const glm::dvec3& sun_lux() const { return sun_lux_; }
    /// On level ground, of all of the sky.
    const glm::dvec3& sky_lux() const { return sky_lux_; }
    /// Light from a direction (unit, not below the horizon): a sky that is so all over would give level ground so many
    /// lux.
    glm::dvec3 from(const glm::dvec3& towards) const;

private:
    /// x, y and luminance of a clear sky, to a factor.
    glm::dvec3 clear_xyz(double cos_zenith, double cos_sun) const;

    glm::dvec3 to_sun_;
    std::array<std::array<double, 5>, 3> perez_{};  ///< of luminance, x and y
    std::array<double, 3> zenith_{};                ///< values there over those of the distribution
    double clear_scale_ = 0.0, overcast_lux_ = 0.0;
    glm::dvec3 sun_lux_{0.0}, sky_lux_{0.0};
};

}  // namespace camrig::daylight
