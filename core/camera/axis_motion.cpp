#include "core/camera/axis_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace camrig::camera {
namespace {

/// Further than this way no axis still has to move: rounding of what it should be.
constexpr double same_place = 1e-12;

double stopping_distance(double speed, double acceleration) {
    return speed * std::abs(speed) / (2.0 * acceleration);
}

/// 1: the motion to the target goes forward once it has done what braking from `from` would do, -1: backward.
double direction_of(const AxisState& from, double target, double acceleration) {
    const double left = target - from.position - stopping_distance(from.speed, acceleration);
    return left < 0.0 ? -1.0 : 1.0;
}

/// The speed at which the way to the target is done without going on at one speed in between.
double peak_speed(const AxisState& from, double target, double direction, double acceleration) {
    const double way = direction * (target - from.position);
    return std::sqrt(std::max(0.0, acceleration * way + 0.5 * from.speed * from.speed));
}

}  // namespace

void AxisMotion::add(double duration_s, double acceleration) {
    if (!(duration_s > 0.0)) return;
    pieces_[static_cast<std::size_t>(count_++)] = {duration_s_, last_, acceleration};
    duration_s_ += duration_s;
    last_.position += (last_.speed + 0.5 * acceleration * duration_s) * duration_s;
    last_.speed += acceleration * duration_s;
}

AxisMotion AxisMotion::over(const AxisState& from, double target, double cruise, double acceleration) {
    AxisMotion motion;
    motion.begin(from);
    const double change = cruise - from.speed;
    motion.add(std::abs(change) / acceleration, std::copysign(acceleration, change));
    motion.last_.speed = cruise;
    if (cruise != 0.0) {
        const double braking = stopping_distance(cruise, acceleration);
        motion.add((target - motion.last_.position - braking) / cruise, 0.0);
        motion.add(std::abs(cruise) / acceleration, -std::copysign(acceleration, cruise));
    }
    motion.end_ = target;
    return motion;
}

AxisMotion AxisMotion::to(const AxisState& from, double target, const AxisLimits& limits) {
    if (from.speed == 0.0 && std::abs(target - from.position) <= same_place) return AxisMotion(target);
    const double direction = direction_of(from, target, limits.acceleration);
    const double peak = peak_speed(from, target, direction, limits.acceleration);
    return over(from, target, direction * std::min(peak, limits.speed), limits.acceleration);
}

AxisMotion AxisMotion::to_in(const AxisState& from, double target, const AxisLimits& limits, double duration_s) {
    AxisMotion fastest = to(from, target, limits);
    if (!(fastest.duration_s() < duration_s) || fastest.duration_s() == 0.0) return fastest;
    // With u the speed it has in the direction of the way d, v that it goes on at and a the acceleration, the way
    // takes  T = (|v - u| + v) / a + (d - what is done while it speeds up and brakes) / v;  solved for v.
    const double a = limits.acceleration, direction = direction_of(from, target, a);
    const double u = direction * from.speed, d = direction * (target - from.position);
    // The smaller root, in the form whose terms do not cancel.
    const double sum = a * duration_s + u, product = a * d + 0.5 * u * u;
    double v = 2.0 * product / (sum + std::sqrt(std::max(0.0, sum * sum - 4.0 * product)));
    if (v < u) v = (d - u * u / (2.0 * a)) / (duration_s - u / a);
    return over(from, target, direction * std::clamp(v, 0.0, limits.speed), a);
}

AxisMotion AxisMotion::at_speed(const AxisState& from, double speed, const AxisLimits& limits) {
    AxisMotion motion;
    motion.begin(from);
    const double change = std::clamp(speed, -limits.speed, limits.speed) - from.speed;
    motion.add(std::abs(change) / limits.acceleration, std::copysign(limits.acceleration, change));
    motion.last_.speed = from.speed + change;
    motion.add(std::numeric_limits<double>::infinity(), 0.0);
    return motion;
}

AxisMotion AxisMotion::stop(const AxisState& from, double acceleration) {
    if (from.speed == 0.0) return AxisMotion(from.position);
    return over(from, from.position + stopping_distance(from.speed, acceleration), 0.0, acceleration);
}

AxisState AxisMotion::at(double seconds) const {
    if (!(seconds < duration_s_)) return {end_, 0.0};
    const auto begin = pieces_.begin();
    const auto next = std::upper_bound(begin, begin + count_, seconds,
                                       [](double time, const Piece& piece) { return time < piece.begin_s; });
    const Piece& piece = next == begin ? *begin : *std::prev(next);
    const double t = std::max(0.0, seconds - piece.begin_s);
    return {piece.from.position + (piece.from.speed + 0.5 * piece.acceleration * t) * t,
            piece.from.speed + piece.acceleration * t};
}

}  // namespace camrig::camera
