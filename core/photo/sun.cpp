#include "core/photo/sun.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

namespace camrig::photo {
namespace {

constexpr double deg = std::numbers::pi / 180.0;
/// A shadow that ends nearer than this to its foot says nothing of the sun.
constexpr double min_shadow_m = 0.02;

double around(double degrees) {
    return degrees - 360.0 * std::floor(degrees / 360.0);
}

std::unexpected<Error> bad(std::string text) {
    return error(ErrorKind::invalid_argument, std::move(text));
}

Result<std::pair<glm::dvec3, double>> direction_of(const PlateView& view, const Shadow& shadow) {
    const auto foot = view.on_ground(shadow.foot_px, shadow.z), tip = view.on_ground(shadow.tip_px, shadow.z);
    if (!foot) return bad("foot: is over the horizon of the ground");
    if (!tip) return bad("tip: is over the horizon of the ground");
    const auto seen = view.ray(shadow.top_px);
    if (!seen) return bad("top: the lens shows nothing there");
    // Of the upright line through the foot, the height nearest to the line of sight.
    const glm::dvec3 along = view.world_from_optical * *seen, from = view.position - *foot;
    const double a = 1.0 - along.z * along.z;
    if (a < 1e-6) return bad("top: is seen from straight above; use another thing");
    const double height = (from.z - along.z * glm::dot(from, along)) / a;
    if (!(height > min_shadow_m)) return bad("top: is not above the foot");
    if (glm::distance(*tip, *foot) < min_shadow_m) return bad("tip: is the foot itself; use a longer shadow");
    return std::pair(glm::normalize(*tip - *foot - glm::dvec3(0, 0, height)), height);
}

}  // namespace

Result<double> read_instant(std::string_view text) {
    const std::string copy(text);
    int year = 0, month = 0, day = 0, hour = 0, minute = 0, used = 0;
    double second = 0.0;
    const char* const wanted = ": expected a time as 2026-06-21T14:30:00+02:00, or with Z for UTC";
    if (copy.size() > 40 ||
        std::sscanf(copy.c_str(), "%4d-%2d-%2dT%2d:%2d%n", &year, &month, &day, &hour, &minute, &used) != 5)
        return bad(copy.substr(0, 40) + wanted);
    const char* rest = copy.c_str() + used;
    if (*rest == ':' && (std::sscanf(rest, ":%lf%n", &second, &used) != 1 || !(second >= 0.0 && second < 61.0)))
        return bad(copy + wanted);
    if (*rest == ':') rest += used;
    int offset_hour = 0, offset_minute = 0;
    double offset = 0.0;
    if ((*rest == '+' || *rest == '-') &&
        std::sscanf(rest + 1, "%2d:%2d%n", &offset_hour, &offset_minute, &used) == 2 && !rest[1 + used])
        offset = (*rest == '-' ? -1.0 : 1.0) * (3600.0 * offset_hour + 60.0 * offset_minute);
    else if (std::string_view(rest) != "Z")
        return bad(copy + wanted);
    const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(unsigned(month)),
                                           std::chrono::day(unsigned(day))};
    if (!date.ok() || hour < 0 || hour > 23 || minute < 0 || minute > 59) return bad(copy + ": there is no such time");
    const double days = double(std::chrono::sys_days(date).time_since_epoch().count());
    return 86400.0 * days + 3600.0 * hour + 60.0 * minute + second - offset;
}

SunPlace sun_at(double unix_s, double latitude_deg, double longitude_deg) {
    const double days = unix_s / 86400.0 + 2440587.5 - 2451545.0, t = days / 36525.0;
    const double longitude = around(280.46646 + t * (36000.76983 + 0.0003032 * t));
    const double anomaly = (357.52911 + t * (35999.05029 - 0.0001537 * t)) * deg;
    const double centre = std::sin(anomaly) * (1.914602 - t * (0.004817 + 0.000014 * t)) +
                          std::sin(2 * anomaly) * (0.019993 - 0.000101 * t) + std::sin(3 * anomaly) * 0.000289;
    const double node = (125.04 - 1934.136 * t) * deg;
    const double apparent = (longitude + centre - 0.00569 - 0.00478 * std::sin(node)) * deg;
    const double mean_tilt = 23.0 + (26.0 + (21.448 - t * (46.815 + t * (0.00059 - t * 0.001813))) / 60.0) / 60.0;
    const double tilt = (mean_tilt + 0.00256 * std::cos(node)) * deg;
    const double declination = std::asin(std::sin(tilt) * std::sin(apparent));
    const double ascension = std::atan2(std::cos(tilt) * std::sin(apparent), std::cos(apparent));
    // Sidereal time at Greenwich (Meeus, 12.4).
    const double sidereal = around(280.46061837 + 360.98564736629 * days + t * t * (0.000387933 - t / 38710000.0));
    const double hour = (sidereal + longitude_deg) * deg - ascension, latitude = latitude_deg * deg;
    const double elevation = std::asin(std::sin(latitude) * std::sin(declination) +
                                       std::cos(latitude) * std::cos(declination) * std::cos(hour));
    const double from_south =
        std::atan2(std::sin(hour), std::cos(hour) * std::sin(latitude) - std::tan(declination) * std::cos(latitude));
    return {around(from_south / deg + 180.0) * deg, elevation};
}

glm::dvec3 light_direction(const SunPlace& sun, double north) {
    const double angle = north - sun.azimuth, level = std::cos(sun.elevation);
    return -glm::dvec3(level * std::cos(angle), level * std::sin(angle), std::sin(sun.elevation));
}

SunPlace sun_of(const glm::dvec3& light_direction, double north) {
    const glm::dvec3 to_sun = -glm::normalize(light_direction);
    const double azimuth = north - std::atan2(to_sun.y, to_sun.x);
    return {around(azimuth / deg) * deg, std::asin(glm::clamp(to_sun.z, -1.0, 1.0))};
}

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
