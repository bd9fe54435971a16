#pragma once

#include <algorithm>
#include <limits>

namespace camrig::camera {

/// A range of numbers that holds every value a formula can have while its inputs run through theirs (interval
/// arithmetic: Moore, Kearfott, Cloud, Introduction to Interval Analysis). Results are not rounded outwards: a range
/// may be short by a few units in the last place.
struct Interval {
    double low = 0.0;
    double high = 0.0;

    double magnitude() const { return std::max(-low, high); }
};

inline Interval hull(double a, double b) {
    return {std::min(a, b), std::max(a, b)};
}
inline Interval widened(Interval a, double by) {
    return {a.low - by, a.high + by};
}
inline Interval operator+(Interval a, Interval b) {
    return {a.low + b.low, a.high + b.high};
}
inline Interval operator+(Interval a, double b) {
    return {a.low + b, a.high + b};
}
inline Interval operator-(Interval a, Interval b) {
    return {a.low - b.high, a.high - b.low};
}
inline Interval operator*(Interval a, double b) {
    return b >= 0.0 ? Interval{a.low * b, a.high * b} : Interval{a.high * b, a.low * b};
}
inline Interval operator*(Interval a, Interval b) {
    const auto [low, high] = std::minmax({a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high});
    return {low, high};
}
/// `b` must not hold 0.
inline Interval operator/(Interval a, Interval b) {
    return a * Interval{1.0 / b.high, 1.0 / b.low};
}
inline Interval square(Interval a) {
    const double most = std::max(a.low * a.low, a.high * a.high);
    if (a.low <= 0.0 && a.high >= 0.0) return {0.0, most};
    return {std::min(a.low * a.low, a.high * a.high), most};
}

}  // namespace camrig::camera
