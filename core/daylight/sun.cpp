#include "core/daylight/sun.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "core/base/portable_math.h"

namespace camrig::daylight {
namespace {

constexpr double deg = std::numbers::pi / 180.0;

double around(double degrees) {
    return degrees - 360.0 * std::floor(degrees / 360.0);
}

double arc_sine(double x) {
    return portable::atan2(x, std::sqrt(std::max(0.0, 1.0 - x * x)));
}

}  // namespace

Result<double> read_instant(std::string_view text) {
    const std::string copy(text);
    int year = 0, month = 0, day = 0, hour = 0, minute = 0, used = 0;
    double second = 0.0;
    const char* const wanted = ": expected a time as 2026-06-21T14:30:00+02:00, or with Z for UTC";
    if (copy.size() > 40 ||
        std::sscanf(copy.c_str(), "%4d-%2d-%2dT%2d:%2d%n", &year, &month, &day, &hour, &minute, &used) != 5)
        return invalid(copy.substr(0, 40) + wanted);
    const char* rest = copy.c_str() + used;
    if (*rest == ':' && (std::sscanf(rest, ":%lf%n", &second, &used) != 1 || !(second >= 0.0 && second < 61.0)))
        return invalid(copy + wanted);
    if (*rest == ':') rest += used;
    int offset_hour = 0, offset_minute = 0;
    double offset = 0.0;
    if ((*rest == '+' || *rest == '-') &&
        std::sscanf(rest + 1, "%2d:%2d%n", &offset_hour, &offset_minute, &used) == 2 && !rest[1 + used])
        offset = (*rest == '-' ? -1.0 : 1.0) * (3600.0 * offset_hour + 60.0 * offset_minute);
    else if (std::string_view(rest) != "Z")
        return invalid(copy + wanted);
    const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(unsigned(month)),
                                           std::chrono::day(unsigned(day))};
    if (!date.ok() || hour < 0 || hour > 23 || minute < 0 || minute > 59)
        return invalid(copy + ": there is no such time");
    const double days = double(std::chrono::sys_days(date).time_since_epoch().count());
    return 86400.0 * days + 3600.0 * hour + 60.0 * minute + second - offset;
}

SunPlace sun_at(double unix_s, double latitude_deg, double longitude_deg) {
    const double days = unix_s / 86400.0 + 2440587.5 - 2451545.0, t = days / 36525.0;
    const double longitude = around(280.46646 + t * (36000.76983 + 0.0003032 * t));
    const double anomaly = (357.52911 + t * (35999.05029 - 0.0001537 * t)) * deg;
    const double centre = portable::sin(anomaly) * (1.914602 - t * (0.004817 + 0.000014 * t)) +
                          portable::sin(2 * anomaly) * (0.019993 - 0.000101 * t) +
                          portable::sin(3 * anomaly) * 0.000289;
    const double node = (125.04 - 1934.136 * t) * deg;
    const double apparent = (longitude + centre - 0.00569 - 0.00478 * portable::sin(node)) * deg;
    const double mean_tilt = 23.0 + (26.0 + (21.448 - t * (46.815 + t * (0.00059 - t * 0.001813))) / 60.0) / 60.0;
    const double tilt = (mean_tilt + 0.00256 * portable::cos(node)) * deg;
    const double declination = arc_sine(portable::sin(tilt) * portable::sin(apparent));
    const double ascension = portable::atan2(portable::cos(tilt) * portable::sin(apparent), portable::cos(apparent));
    // Sidereal time at Greenwich (Meeus, 12.4).
    const double sidereal = around(280.46061837 + 360.98564736629 * days + t * t * (0.000387933 - t / 38710000.0));
    const double hour = (sidereal + longitude_deg) * deg - ascension, latitude = latitude_deg * deg;
    const double elevation = arc_sine(portable::sin(latitude) * portable::sin(declination) +
                                      portable::cos(latitude) * portable::cos(declination) * portable::cos(hour));
    const double from_south =
        portable::atan2(portable::sin(hour), portable::cos(hour) * portable::sin(latitude) -
                                                 portable::tan(declination) * portable::cos(latitude));
    return {around(from_south / deg + 180.0) * deg, elevation};
}

glm::dvec3 light_direction(const SunPlace& sun, double north) {
    const double angle = north - sun.azimuth, level = portable::cos(sun.elevation);
    return -glm::dvec3(level * portable::cos(angle), level * portable::sin(angle), portable::sin(sun.elevation));
}

SunPlace sun_of(const glm::dvec3& light_direction, double north) {
    const glm::dvec3 to_sun = -glm::normalize(light_direction);
    const double azimuth = north - portable::atan2(to_sun.y, to_sun.x);
    return {around(azimuth / deg) * deg, arc_sine(glm::clamp(to_sun.z, -1.0, 1.0))};
}

}  // namespace camrig::daylight
