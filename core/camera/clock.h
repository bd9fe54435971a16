#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/clock_reading.h"
#include "core/camera/clock_spec.h"

namespace camrig::camera {

/// A camera's clock as a function of world time, in integer nanoseconds. Any time may be asked for, in any order, with
/// the same answer, after years as after a second; nothing is summed up.
///
/// In state free it says `t + offset + drift * t + walk(t) + jitter`. With a server or master it is `offset` and a
/// wandering rest beside the true time. What it is told later it takes on from where it is then: a new drift bends it,
/// a server or master that comes pulls it to the true time at 500 ppm (the fastest that Linux and ntpd slew), or sets
/// it when it is wrong by more than a second; only a new offset or step sets it at once.
///
/// A value; any thread.
class Clock {
public:
    static constexpr TimeNs kept_ns = 250 * ns_per_ms;  ///< so much of the past is kept when it is told something
    static constexpr std::size_t max_segments = 64;     ///< more commands than this within kept_ns shorten the past
    static constexpr TimeNs tai_minus_utc_ns = 37 * ns_per_s;  ///< since 2017 (IERS Bulletin C)

    /// nullopt: the camera has no clock of its own and is right.
    explicit Clock(const std::optional<ClockSpec>& spec = std::nullopt);

    /// From begin_ns on it is another. A clock where none was counts from world time 0.
    void set(const std::optional<ClockSpec>& spec, TimeNs begin_ns);

    /// What a picture of that time is stamped with; nullopt: the true time. The steady clock never goes back: its
    /// jitter is cut to less than half of `apart_ns`, the time from one picture to the next.
    std::optional<ClockReading> at(TimeNs world_ns, TimeNs apart_ns = max_time_ns) const;

private:
    /// From begin_ns on; the spec is nullopt where there is no clock.
    struct Segment {
        TimeNs begin_ns = 0;
        TimeNs since_ns = 0;  ///< what goes on with time goes on from there
        std::optional<ClockSpec> spec = {};
        TimeNs carried_ns = 0;  ///< by how much it was wrong at since_ns, beside what the spec says of that time
        TimeNs stepped_ns = 0;  ///< what it was set by since the first segment, step_ns apart
    };
    /// How wrong it is, without step_ns and jitter.
    static TimeNs error_ns(const Segment& segment, TimeNs world_ns);
    /// How fast it runs, without its walk and what a server or master leaves of wandering.
    static std::int64_t drift_ppb(const Segment& segment, TimeNs world_ns);
    static Segment following(const Segment& before, const std::optional<ClockSpec>& spec, TimeNs begin_ns);

    std::vector<Segment> segments_;  ///< by begin_ns; never empty
};

}  // namespace camrig::camera
