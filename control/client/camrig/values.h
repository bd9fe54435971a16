#pragma once

#include <array>
#include <cstdint>
#include <optional>

/// Value types of the API.
namespace camrig::client {

using Vector2 = std::array<double, 2>;
using Vector3 = std::array<double, 3>;
/// x, y, z, w
using Quaternion = std::array<double, 4>;

/// In pixels.
struct Size {
    int width = 0;
    int height = 0;
    friend bool operator==(Size a, Size b) { return a.width == b.width && a.height == b.height; }
    friend bool operator!=(Size a, Size b) { return !(a == b); }
};

/// Frames per second as an exact fraction. A number is taken as the decimal it is written as: 29.97 is 2997/100.
struct Rate {
    std::int64_t num = 25;
    std::int64_t den = 1;

    Rate() = default;
    Rate(std::int64_t numerator, std::int64_t denominator) : num(numerator), den(denominator) {}
    Rate(int hertz) : num(hertz) {}
    /// Error invalid_argument unless 1/10 to 1000.
    Rate(double hertz);
    double hertz() const { return static_cast<double>(num) / static_cast<double>(den); }
    friend bool operator==(Rate a, Rate b) { return a.num == b.num && a.den == b.den; }
    friend bool operator!=(Rate a, Rate b) { return !(a == b); }
};

/// A number, or automatic (nullopt): the rig chooses.
struct NumberOrAuto {
    std::optional<double> number = {};

    NumberOrAuto() = default;
    NumberOrAuto(double given) : number(given) {}
};

/// The state of what a command has made or changed, and the world time from which that shows.
template <typename State>
struct Applied : State {
    std::int64_t applied_ns = 0;
};

}  // namespace camrig::client
