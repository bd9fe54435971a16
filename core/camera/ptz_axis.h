#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/camera/axis_motion.h"
#include "core/camera/ptz_spec.h"

namespace camrig::camera {

/// Of what goes on for ever.
inline constexpr TimeNs never_ns = std::numeric_limits<TimeNs>::max();

/// The first whole nanosecond that is no less later; never_ns where that is too far to be told.
TimeNs later_by(TimeNs from_ns, double seconds);

/// One motion of an axis, from a time on, and how far it is from where it believes to be, before and after. Before it
/// begins it stands.
struct PtzMotion {
    TimeNs told_ns = 0, begin_ns = 0;
    AxisMotion motion;
    double error_from = 0.0, error_to = 0.0;

    AxisState motor(TimeNs world_ns) const;
    double error(TimeNs world_ns) const;
    TimeNs end_ns() const { return later_by(begin_ns, motion.duration_s()); }
};

/// Where an axis may go, and how wrong it stops: by its repeatability, each time otherwise, and by half of its backlash
/// against its way. Its random numbers are functions of seed, stream and stop.
struct PtzAxisOptions {
    std::optional<PtzLimits> limits;  ///< nullopt: it turns without end
    double repeatability = 0.0, backlash = 0.0;
    std::uint64_t seed = 0, stream = 0;
};

/// The way from one stop of a tour to the next.
struct PtzTourLeg {
    TimeNs begin_ns = 0;  ///< since the round began, which is where it came to the first stop
    AxisMotion motion;
};

/// One axis of a head as a function of world time: motions that follow each other, each a closed form, and the tour,
/// which is a closed form that repeats. States may be asked for in any order. A value.
class PtzAxis {
public:
    /// Stands at 0, or the nearest to that within its limits.
    explicit PtzAxis(PtzAxisOptions options);
    /// Of its motor: without errors, and further than a turn where it turns without end.
    AxisState motor(TimeNs world_ns) const { return motion(world_ns).motor(world_ns); }
    /// Where it is, with its errors; within its limits.
    double position(TimeNs world_ns) const;
    /// Where it believes to be, as its encoder tells.
    double believed(TimeNs world_ns, double quantum) const;
    /// From the command on, until it stands.
    bool is_moving(TimeNs world_ns) const;
    /// Of its last motion; never_ns of one without end and of a tour.
    TimeNs end_ns() const;
    /// The nearest to it that it can come to.
    double within(double target) const;
    /// The same; without limits, of the positions that are the same turned round, the nearest to `from`.
    double nearest(double target, double from) const;
    /// The nearest to it that it can come to by the shorter way round.
    double towards(double target, double from) const;
    /// Its motions that are still to begin.
    std::size_t pending(TimeNs now_ns) const;

    /// A motion from where its motor is then; it takes the place of all that begins later.
    void go(TimeNs told_ns, TimeNs begin_ns, const AxisMotion& motion);
    void go_at_speed(TimeNs told_ns, TimeNs begin_ns, double speed, const AxisLimits& limits);
    void brake(TimeNs told_ns, TimeNs begin_ns, double acceleration);
    /// Over and over along legs in their order, each from where the one before ends, the first from where it stands at
    /// begin_ns. A round takes round_ns, no less than its legs.
    void tour(TimeNs told_ns, TimeNs begin_ns, TimeNs round_ns, std::vector<PtzTourLeg> legs);
    /// The last it was told is a tour.
    bool is_on_tour() const { return segments_.back().rounds != nullptr; }
    /// Of another world, whose time begins at 0: it stands where it comes to; what never ends, where it was at that
    /// time.
    PtzAxis standing(TimeNs last_ns) const;

    /// Slower than this is a stand.
    static constexpr double least_speed = 1e-6;
    /// More motions than this are not kept of the past, nor taken before they begin.
    static constexpr std::size_t max_segments = 64;

private:
    class Rounds;
    struct Segment {
        PtzMotion motion;
        std::shared_ptr<const Rounds> rounds = {};  ///< of a tour, instead of the motion
    };

    PtzMotion motion(TimeNs world_ns) const;
    void add(TimeNs told_ns, const Segment& added);
    void add_motion(TimeNs told_ns, TimeNs begin_ns, const AxisMotion& motion, std::optional<double> error);

    PtzAxisOptions options_;
    std::vector<Segment> segments_;  ///< by the begin of their motions; never empty
    std::uint64_t stops_ = 0;
};

}  // namespace camrig::camera
