#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

/// Unreal Engine's units and axes: centimetres, degrees, left-handed, x forward, y right, z up. The axes are camrig's
/// with y mirrored. A rotation is pitch, yaw, roll in this order; pan = -yaw, tilt = pitch, roll = roll (checked
/// against FRotationMatrix, Engine/Source/Runtime/Core/Public/Math/RotationTranslationMatrix.h).
#include "core/camera/pose.h"

namespace camrig::unrealcv {

inline glm::dvec3 location_of(const glm::dvec3& metres) {
    return {100.0 * metres.x, -100.0 * metres.y, 100.0 * metres.z};
}
inline glm::dvec3 metres_of(const glm::dvec3& location) {
    return {location.x / 100.0, -location.y / 100.0, location.z / 100.0};
}
/// Degrees as {pitch, yaw, roll}; yaw and roll in (-180, 180].
glm::dvec3 rotation_of(const glm::dquat& orientation);
glm::dquat orientation_of(const glm::dvec3& rotation);

/// "1.000 -2.500 0.000": numbers as the plugin prints them, which has no negative zero.
std::string text_of(const glm::dvec3& v, int digits = 3, std::string_view between = " ");
std::string number_text(double number, int digits);

/// In centimetres and degrees alike: what camrig takes in metres.
inline constexpr double max_number = 100.0 * camera::max_coordinate_m;
/// A number as users' programs print it, with or without exponent; nothing: it is none, or beyond max_number.
std::optional<double> number_of(std::string_view text);
/// Digits alone, below 2^31.
std::optional<int> integer_of(std::string_view text);

}  // namespace camrig::unrealcv
