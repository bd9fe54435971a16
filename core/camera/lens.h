#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

#include "core/base/named.h"

namespace camrig::camera {

/// The lens models of OpenCV and ROS, by their ROS names (sensor_msgs/distortion_models).
enum class LensModel : std::uint8_t { pinhole, plumb_bob, rational_polynomial, equidistant };

std::span<const Named<LensModel>> names_of(std::type_identity<LensModel>);
/// How many coefficients a model takes: 0, 5, 8, 4.
int coefficient_count(LensModel model);

/// A lens: model and coefficients in ROS/OpenCV order
/// (plumb_bob k1 k2 p1 p2 k3 | rational_polynomial k1 k2 p1 p2 k3 k4 k5 k6 | equidistant k1 k2 k3 k4); the rest is 0.
/// This is plain data; the mathematics (forward, inverse, derivative, valid radius) is LensMap in lens_map.h.
struct Lens {
    LensModel model = LensModel::pinhole;
    std::array<double, 8> coefficients{};
    friend bool operator==(const Lens&, const Lens&) = default;
};

}  // namespace camrig::camera
