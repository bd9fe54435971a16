#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"
#include "core/camera/axis_motion.h"
#include "core/camera/ptz_spec.h"
#include "core/camera/ptz_status.h"

namespace camrig::camera {

/// How an axis is to move; what is empty stays as it is.
enum class PtzMode : std::uint8_t { absolute, relative, continuous };
std::span<const Named<PtzMode>> names_of(std::type_identity<PtzMode>);

struct PtzMove {
    PtzMode mode = PtzMode::absolute;
    /// absolute: where to; relative: by how much; continuous: degrees a second.
    std::optional<double> pan_deg = {}, tilt_deg = {};
    /// absolute: the factor; relative: its multiple; continuous: of the head's own zoom speed, -1 to 1.
    std::optional<double> zoom = {};
    double speed = 1.0;                  ///< share of the head's speed: over 0, at most 1
    std::optional<TimeNs> timeout = {};  ///< of a continuous move: it stops by itself
};

/// A pan/tilt/zoom head as a function of world time: what it was told so far, and what follows from that for any time.
///
/// Each axis goes as fast as its limits let it and both angles of a move arrive together. Zoom goes by equal factors a
/// second. A command takes the place of what its axes do, from its latency on; what is pending then is given up. States
/// may be asked for in any order. Random numbers (where it stops) are functions of seed, axis and stop.
///
/// A value; any thread.
class PtzHead {
public:
    /// Stands at pan 0 and tilt 0, or the nearest to that within its limits, at the wide end.
    explicit PtzHead(const PtzSpec& spec);

    /// invalid_argument: beyond the limits of an absolute move; others end there.
    Result<void> move(const PtzMove& move, TimeNs now_ns);
    /// Turns to the nearest to that within its limits; zoom stays.
    Result<void> aim(const PtzPosition& at, double speed, TimeNs now_ns);
    /// resource_exhausted, so do all: too many commands are still to come.
    Result<void> stop(bool pan_and_tilt, bool zoom, TimeNs now_ns);

    static constexpr std::size_t max_presets = 256;
    /// Remembers where it believes to be at that time. resource_exhausted: there are as many as there may be.
    Result<void> set_preset(const std::string& name, TimeNs now_ns);
    /// not_found: there is none of that name; so of the next.
    Result<void> go_to_preset(const std::string& name, TimeNs now_ns);
    Result<void> remove_preset(const std::string& name);
    const std::map<std::string, PtzPosition>& presets() const { return presets_; }
    void set_home(TimeNs now_ns) { home_ = status(now_ns).position; }
    /// At first where it stood in the beginning.
    Result<void> go_home(TimeNs now_ns) { return go_to(home_, now_ns); }

    /// Where it truly is.
    PtzPosition at(TimeNs world_ns) const;
    PtzStatus status(TimeNs world_ns) const;
    /// World time from which it stands; the largest there is when it never will.
    TimeNs arrives_ns() const;
    bool never_stands() const;
    /// Of another world, whose time begins at 0: it stands where it comes to; what never ends, where it was at that
    /// time.
    PtzHead standing(TimeNs last_ns) const;
    const PtzSpec& spec() const { return spec_; }

private:
    /// One motion of an axis, from a time on, and how far it is from where it believes to be, before and after.
    struct Segment {
        TimeNs told_ns = 0, begin_ns = 0;
        AxisMotion motion;
        double error_from = 0.0, error_to = 0.0;

        AxisState motor(TimeNs world_ns) const;
        double error(TimeNs world_ns) const;
        TimeNs end_ns() const;
    };
    struct AxisOptions {
        std::optional<PtzLimits> limits;  ///< nullopt: it turns without end
        double repeatability = 0.0, backlash = 0.0;
        std::uint64_t seed = 0, stream = 0;  ///< of random numbers
    };
    class Axis {
    public:
        explicit Axis(AxisOptions options);
        AxisState motor(TimeNs world_ns) const { return segment(world_ns).motor(world_ns); }
        /// Where it is, with its errors; within its limits.
        double position(TimeNs world_ns) const;
        /// Where it believes to be, as its encoder tells.
        double believed(TimeNs world_ns, double quantum) const;
        bool is_moving(TimeNs world_ns) const;
        TimeNs end_ns() const { return segments_.back().end_ns(); }
        /// The nearest to it that it can come to.
        double within(double target) const;
        /// The same; without limits, of the positions that are the same turned round, the nearest to `from`.
        double nearest(double target, double from) const;
        std::size_t pending(TimeNs now_ns) const;
        void go(TimeNs told_ns, TimeNs begin_ns, const AxisMotion& motion);
        void go_at_speed(TimeNs told_ns, TimeNs begin_ns, double speed, const AxisLimits& limits);
        void brake(TimeNs told_ns, TimeNs begin_ns, double acceleration);
        Axis standing(TimeNs last_ns) const;

    private:
        const Segment& segment(TimeNs world_ns) const;
        void add(TimeNs told_ns, TimeNs begin_ns, const AxisMotion& motion, std::optional<double> error);

        AxisOptions options_;
        std::vector<Segment> segments_;  ///< by begin_ns; never empty
        std::uint64_t stops_ = 0;
    };

    AxisLimits angle_limits(const PtzMove& move, TimeNs begin_ns) const;
    AxisLimits zoom_limits(double share) const;
    double zoom_of(TimeNs world_ns) const;
    Result<void> check_room(TimeNs now_ns) const;
    Result<void> go_to(const PtzPosition& position, TimeNs now_ns);
    /// When a continuous move begins that is told now: one without speed is a stop.
    TimeNs begin_at_speed(double speed, TimeNs now_ns) const;
    void turn(const PtzMove& move, TimeNs now_ns);
    void run_zoom(const PtzMove& move, TimeNs now_ns);

    PtzSpec spec_;
    Axis pan_, tilt_;
    Axis zoom_;  ///< natural logarithm of the factor
    std::map<std::string, PtzPosition> presets_;
    PtzPosition home_;
};

}  // namespace camrig::camera
