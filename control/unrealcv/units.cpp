#include "control/unrealcv/units.h"

#include <charconv>
#include <cmath>
#include <cstdio>

#include "core/camera/pose.h"

namespace camrig::unrealcv {
namespace {

/// From angles in [-180, 180], where half a turn is one to the last digits.
double half_open(double degrees) {
    return degrees <= -180.0 + 1e-9 ? 180.0 : degrees;
}

}  // namespace

glm::dvec3 rotation_of(const glm::dquat& orientation) {
    const camera::PanTiltRoll angles = camera::angles_of(orientation);
    return {glm::degrees(angles.tilt), half_open(-glm::degrees(angles.pan)), half_open(glm::degrees(angles.roll))};
}

glm::dquat orientation_of(const glm::dvec3& rotation) {
    // Whole turns are taken off where that is exact.
    const auto radians = [](double degrees) { return glm::radians(std::remainder(degrees, 360.0)); };
    const auto pose = camera::pose_from_angles(
        {}, {.pan = -radians(rotation.y), .tilt = radians(rotation.x), .roll = radians(rotation.z)});
    return pose->orientation;
}

std::string number_text(double number, int digits) {
    char text[400];
    std::snprintf(text, sizeof text, "%.*f", digits, number);
    std::string_view made(text);
    if (made.starts_with('-') && made.find_first_of("123456789") == std::string_view::npos) made.remove_prefix(1);
    return std::string(made);
}

std::string text_of(const glm::dvec3& v, int digits, std::string_view between) {
    std::string text = number_text(v.x, digits);
    for (const double part : {v.y, v.z}) (text += between) += number_text(part, digits);
    return text;
}

std::optional<double> number_of(std::string_view text) {
    if (text.starts_with('+')) text.remove_prefix(1);
    double number = 0.0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (failed != std::errc() || end != text.data() + text.size() || !(std::abs(number) <= max_number))
        return std::nullopt;
    return number;
}

std::optional<int> integer_of(std::string_view text) {
    int number = 0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (failed != std::errc() || end != text.data() + text.size() || number < 0) return std::nullopt;
    return number;
}

}  // namespace camrig::unrealcv
