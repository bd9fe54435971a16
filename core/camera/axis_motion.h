#pragma once

#include <array>

namespace camrig::camera {

/// Where something is along one axis and how fast it moves; the axis has any unit (degrees, logarithm of a focal
/// length), times are seconds.
struct AxisState {
    double position = 0.0;
    double speed = 0.0;
    friend bool operator==(const AxisState&, const AxisState&) = default;
};

/// The largest speed and the one acceleration of an axis; both over 0.
struct AxisLimits {
    double speed = 0.0;
    double acceleration = 0.0;
};

/// A motion along one axis with pieces of constant acceleration (0 or that of its limits, either way): a closed form of
/// the time since it began. In the end it stands, exactly where it was to come to. A value type.
class AxisMotion {
public:
    /// Stands.
    explicit AxisMotion(double position = 0.0) : end_(position) {}

    /// The fastest way to a stand at `target`. Who is faster than the limits slows down first; who cannot stop in time
    /// comes back. Speed: position and limits of both states as they are, so nothing jumps.
    static AxisMotion to(const AxisState& from, double target, const AxisLimits& limits);
    /// The same at a lower speed on the way, so that it takes duration_s, which is no less than to() takes.
    static AxisMotion to_in(const AxisState& from, double target, const AxisLimits& limits, double duration_s);
    /// To that speed, and on for ever.
    static AxisMotion at_speed(const AxisState& from, double speed, const AxisLimits& limits);
    /// Brakes, and stands where that ends.
    static AxisMotion stop(const AxisState& from, double acceleration);

    AxisState at(double seconds) const;
    /// Infinite of one that goes on for ever.
    double duration_s() const { return duration_s_; }
    /// The position at which it stops; not defined for a motion without an end.
    double end() const { return end_; }

private:
    struct Piece {
        double begin_s = 0.0;
        AxisState from;
        double acceleration = 0.0;
    };

    void begin(const AxisState& from) { end_ = from.position, last_ = from; }
    void add(double duration_s, double acceleration);
    /// To the speed `cruise` (signed), on at it, and to a stand at `target`.
    static AxisMotion over(const AxisState& from, double target, double cruise, double acceleration);

    static constexpr int max_pieces = 3;
    std::array<Piece, max_pieces> pieces_{};
    int count_ = 0;
    double duration_s_ = 0.0;
    AxisState last_;    ///< where the pieces so far lead to
    double end_ = 0.0;  ///< exactly, free of the pieces' rounding
};

}  // namespace camrig::camera
