#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"
#include "core/camera/ptz_axis.h"
#include "core/camera/ptz_spec.h"
#include "core/camera/ptz_status.h"

namespace camrig::camera {

/// How an axis is to move; what is empty stays as it is.
enum class PtzMode : std::uint8_t { absolute, relative, continuous, fov };
std::span<const Named<PtzMode>> names_of(std::type_identity<PtzMode>);

struct PtzMove {
    PtzMode mode = PtzMode::absolute;
    /// absolute: where to; relative: by how much; continuous: degrees a second.
    std::optional<double> pan_deg = {}, tilt_deg = {};
    /// fov: the place in the picture that comes to its middle, to the right and upwards, in halves of the picture.
    std::optional<double> x = {}, y = {};
    /// absolute: the factor; relative and fov: its multiple; continuous: of the head's own zoom speed, -1 to 1.
    std::optional<double> zoom = {};
    double speed = 1.0;                  ///< share of the head's speed: over 0, at most 1
    std::optional<TimeNs> timeout = {};  ///< of a continuous move: it stops by itself
};

/// A place of a tour.
struct PtzTourStop {
    std::string preset;
    TimeNs dwell = 5 * ns_per_s;  ///< from when all axes stand there; 0.1 s to a day
    double speed = 1.0;           ///< share of the head's speed on the way to it: 0.001 to 1
    friend bool operator==(const PtzTourStop&, const PtzTourStop&) = default;
};
/// Over and over, the last is followed by the first.
using PtzTour = std::vector<PtzTourStop>;

/// A pan/tilt/zoom head as a function of world time: what it was told so far, and what follows from that for any time.
///
/// Each axis goes as fast as its limits let it and both angles of a move arrive together. Zoom goes by equal factors a
/// second. A command takes the place of what its axes do, from its latency on; what is pending then is given up; a
/// tour is over with any command that moves an axis. States may be asked for in any order. Random numbers (where it
/// stops) are functions of seed, axis and stop.
///
/// A value; any thread.
class PtzHead {
public:
    /// Stands at pan 0 and tilt 0, or the nearest to that within its limits, at the wide end.
    explicit PtzHead(const PtzSpec& spec);

    /// invalid_argument: beyond the limits of an absolute move; others end there. A place in the picture is known to
    /// who knows the lens (world::Camera::in_angles): in mode fov the angles are where that lies.
    Result<void> move(const PtzMove& move, TimeNs now_ns);
    /// resource_exhausted, so do all: too many commands are still to come.
    Result<void> stop(bool pan_and_tilt, bool zoom, TimeNs now_ns);

    static constexpr std::size_t max_presets = 256;
    /// Remembers where it believes to be at that time. resource_exhausted: there are as many as there may be.
    Result<void> set_preset(const std::string& name, TimeNs now_ns);
    /// speed: a share of its own. not_found: there is none of that name; so of the next.
    Result<void> go_to_preset(const std::string& name, double speed, TimeNs now_ns);
    Result<void> remove_preset(const std::string& name);
    const std::map<std::string, PtzPosition>& presets() const { return presets_; }

    static constexpr std::size_t max_tours = 16, max_tour_stops = 64;
    /// invalid_argument: too many stops, or none. not_found: no preset of that name. resource_exhausted: there are as
    /// many tours as there may be.
    Result<void> set_tour(const std::string& name, PtzTour tour);
    /// not_found: there is none of that name, so of the next; or a preset of it has gone.
    Result<void> start_tour(const std::string& name, TimeNs now_ns);
    /// One that goes on is not stopped.
    Result<void> remove_tour(const std::string& name);
    const std::map<std::string, PtzTour>& tours() const { return tours_; }
    /// The name of the one that it was told to go on last; nullopt: another command came after it.
    std::optional<std::string> tour() const { return pan_.is_on_tour() ? std::optional(tour_) : std::nullopt; }

    const PtzPosition& home() const { return home_; }
    void set_home(TimeNs now_ns) { home_ = status(now_ns).position; }
    /// At first where it stood in the beginning.
    Result<void> go_home(double speed, TimeNs now_ns) { return go_to(home_, speed, now_ns); }

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
    /// What the zoom divides the speed of turning by.
    double slower_by(const PtzMove& move, TimeNs begin_ns) const;
    AxisLimits angle_limits(const PtzMove& move, TimeNs begin_ns) const;
    AxisLimits zoom_limits(double share) const;
    double zoom_of(TimeNs world_ns) const;
    Result<void> check_room(TimeNs now_ns) const;
    Result<PtzPosition> preset(const std::string& name) const;
    Result<void> go_to(const PtzPosition& position, double speed, TimeNs now_ns);
    /// Axes that are on a tour brake.
    void leave_tour(double latency_s, TimeNs now_ns);
    /// When a continuous move begins that is told now: one without speed is a stop.
    TimeNs begin_at_speed(double speed, TimeNs now_ns) const;
    void turn(const PtzMove& move, TimeNs now_ns);
    void run_zoom(const PtzMove& move, TimeNs now_ns);

    PtzSpec spec_;
    PtzAxis pan_, tilt_;
    PtzAxis zoom_;  ///< natural logarithm of the factor
    std::map<std::string, PtzPosition> presets_;
    PtzPosition home_;
    std::map<std::string, PtzTour> tours_;
    std::string tour_;  ///< that was started last
};

}  // namespace camrig::camera
