#include "core/daylight/sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/black_body.h"
#include "core/base/portable_math.h"

namespace camrig::daylight {
namespace {

using std::numbers::pi;
constexpr double degree = pi / 180.0;
/// Of the sun before the air.
constexpr double solar_lux = 133.8e3;
constexpr double night_lux = 2e-3;
/// A clear sky gives at least this share of all light.
constexpr double least_sky = 0.05;
constexpr double sun_radius_deg = 0.267;
/// The sky is summed up at so many places.
constexpr int rows = 24, columns = 48;

double power(double base, double exponent) {
    return base > 0.0 ? portable::exp(exponent * portable::log(base)) : 0.0;
}
double angle_of(double cosine) {
    return portable::atan2(std::sqrt(std::max(0.0, 1.0 - cosine * cosine)), cosine);
}
double luminance(const glm::dvec3& rgb) {
    return glm::dot(rgb, glm::dvec3(0.2126, 0.7152, 0.0722));
}

/// Level ground, sun and sky.
double clear_lux(double elevation_deg) {
    struct Piece {
        double from_deg;
        std::array<double, 4> log10_lux;
    };
    constexpr std::array pieces{
        Piece{20.0, {3.74, 3.97, -4.07, 1.47}},         Piece{5.0, {3.05, 13.28, -45.98, 64.33}},
        Piece{-0.8, {2.88, 22.26, -207.64, 1034.30}},   Piece{-5.0, {2.88, 21.81, -258.11, -858.36}},
        Piece{-12.0, {2.70, 12.17, -431.69, -1899.83}}, Piece{-18.0, {13.84, 262.72, 1447.42, 2797.93}}};
    for (const auto& [from_deg, c] : pieces) {
        if (elevation_deg < from_deg) continue;
        const double x = elevation_deg / 90.0;
        return night_lux + portable::exp(std::numbers::ln10 * (c[0] + x * (c[1] + x * (c[2] + x * c[3]))));
    }
    return night_lux;
}

double air_mass(double elevation_deg) {
    return 1.0 / (portable::sin(elevation_deg * degree) + 0.50572 * power(elevation_deg + 6.07995, -1.6364));
}
double rayleigh_depth(double m) {
    if (m > 20.0) return 1.0 / (10.4 + 0.718 * m);
    return 1.0 / (6.6296 + m * (1.7513 + m * (-0.1202 + m * (0.0065 - 0.00013 * m))));
}

/// What the air leaves of the sun's colour; its luminance is 1. Rayleigh and Ångström at 610, 550 and 465 nm; how much
/// haze there is from the turbidity by Dogniaux (1974), for 2 cm of water.
glm::dvec3 sun_color(double m, double turbidity) {
    // Before the air it is that of 5800 K.
    const std::array<double, 3> balance = white_balance_of(5800.0);
    const double haze = std::max(0.0, turbidity - 2.3) / 16.4;
    glm::dvec3 color;
    constexpr std::array wave_um{0.610, 0.550, 0.465};
    for (int i = 0; i < 3; ++i) {
        const double rayleigh = 0.008735 * power(wave_um[std::size_t(i)], -4.08);
        const double aerosol = haze * power(wave_um[std::size_t(i)], -1.3);
        color[i] = portable::exp(-m * (rayleigh + aerosol)) / balance[std::size_t(i)];
    }
    return color / luminance(color);
}

double perez(const std::array<double, 5>& c, double cos_zenith, double cos_sun, double sun_angle) {
    return (1.0 + c[0] * portable::exp(c[1] / std::max(cos_zenith, 0.01))) *
           (1.0 + c[2] * portable::exp(c[3] * sun_angle) + c[4] * cos_sun * cos_sun);
}

double zenith_chromaticity(const std::array<std::array<double, 4>, 3>& m, double turbidity, double sun_zenith) {
    double sum = 0.0;
    for (const auto& row : m)
        sum = sum * turbidity + (((row[0] * sun_zenith + row[1]) * sun_zenith + row[2]) * sun_zenith + row[3]);
    return sum;
}

glm::dvec3 srgb_of_xyz(const glm::dvec3& c) {
    return glm::max(glm::dvec3(3.2406 * c.x - 1.5372 * c.y - 0.4986 * c.z, -0.9689 * c.x + 1.8758 * c.y + 0.0415 * c.z,
                               0.0557 * c.x - 0.2040 * c.y + 1.0570 * c.z),
                    glm::dvec3(0.0));
}

/// CIE S 011 type 16, so that level ground has 1.
double overcast_share(double cos_zenith) {
    return (9.0 / 7.0) * (1.0 + 2.0 * cos_zenith) / 3.0;
}

}  // namespace

Sky::Sky(const glm::dvec3& to_sun, const Air& air) : to_sun_(to_sun) {
    const double t = std::clamp(air.turbidity, 2.0, 10.0), overcast = std::clamp(air.overcast, 0.0, 1.0);
    perez_ = {
        {{0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771, -0.0670 * t + 0.3703},
         {-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989, -0.0033 * t + 0.0452},
         {-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537,
          -0.0109 * t + 0.0529}}};
    // The model ends at the horizon: in twilight the sky looks as with the sun there, and only becomes darker.
    const double elevation_deg = 90.0 - angle_of(to_sun.z) / degree;
    const double sun_zenith = std::min(angle_of(to_sun.z), 89.0 * degree), cos_sun_zenith = portable::cos(sun_zenith);
    constexpr std::array<std::array<double, 4>, 3> x_zenith{{{0.00166, -0.00375, 0.00209, 0.0},
                                                             {-0.02903, 0.06377, -0.03202, 0.00394},
                                                             {0.11693, -0.21196, 0.06052, 0.25886}}};
    constexpr std::array<std::array<double, 4>, 3> y_zenith{{{0.00275, -0.00610, 0.00317, 0.0},
                                                             {-0.04214, 0.08970, -0.04153, 0.00516},
                                                             {0.15346, -0.26756, 0.06670, 0.26688}}};
    zenith_ = {1.0, zenith_chromaticity(x_zenith, t, sun_zenith), zenith_chromaticity(y_zenith, t, sun_zenith)};
    for (std::size_t i = 0; i < 3; ++i) zenith_[i] /= perez(perez_[i], 1.0, cos_sun_zenith, sun_zenith);

    const double all = clear_lux(elevation_deg), m = air_mass(std::max(elevation_deg, 0.0));
    // The disc sets within half a degree.
    const double risen = std::clamp(0.5 + 0.5 * elevation_deg / sun_radius_deg, 0.0, 1.0);
    double sun = risen * solar_lux * portable::exp(-0.8662 * t * m * rayleigh_depth(m));
    const double height = std::max(to_sun.z, 0.0);
    if (sun * height > (1.0 - least_sky) * all) sun = (1.0 - least_sky) * all / height;
    sun_lux_ = (1.0 - overcast) * sun * sun_color(m, t);

    glm::dvec3 sum(0.0);
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            // Rows of equal cosine squared weigh alike on level ground.
            const double up = std::sqrt((row + 0.5) / rows), level = std::sqrt(1.0 - up * up);
            const double pan = 2.0 * pi * (column + 0.5) / columns;
            const glm::dvec3 towards(level * portable::cos(pan), level * portable::sin(pan), up);
            sum += clear_xyz(up, glm::dot(towards, to_sun_));
        }
    const glm::dvec3 mean = srgb_of_xyz(sum / double(rows * columns));
    clear_scale_ = (1.0 - overcast) * (all - sun * height) / luminance(mean);
    // Below the horizon clouds take what they take there.
    const double share = (300.0 + 21000.0 * height) / (elevation_deg > 0.0 ? all : clear_lux(0.0));
    overcast_lux_ = overcast * all * std::min(share, 1.0);
    sky_lux_ = clear_scale_ * mean + glm::dvec3(overcast_lux_);
}

glm::dvec3 Sky::clear_xyz(double cos_zenith, double cos_sun) const {
    const double angle = angle_of(std::clamp(cos_sun, -1.0, 1.0));
    std::array<double, 3> v{};
    for (std::size_t i = 0; i < 3; ++i) v[i] = zenith_[i] * perez(perez_[i], cos_zenith, cos_sun, angle);
    const double luminance = std::max(v[0], 0.0);
    return {luminance * v[1] / v[2], luminance, luminance * (1.0 - v[1] - v[2]) / v[2]};
}

glm::dvec3 Sky::from(const glm::dvec3& towards) const {
    const double up = std::max(towards.z, 0.0);
    return clear_scale_ * srgb_of_xyz(clear_xyz(up, glm::dot(towards, to_sun_))) +
           glm::dvec3(overcast_lux_ * overcast_share(up));
}

}  // namespace camrig::daylight
