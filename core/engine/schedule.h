#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/camera/exposure_times.h"

namespace camrig::engine {

/// Which camera is due when. Pure arithmetic on world time; knows no clock.
///
/// Every camera runs on the grid of its rate from world time 0, so cameras of one rate are due together whenever they
/// were made, unless a clock of their own moves them (ExposureTimes). A camera whose pictures take longer than a period
/// is due every stride-th grid point. Sequence numbers rise by one per due frame, for the whole life of a camera, also
/// across a change of rate. Thread: the engine's.
class Schedule {
public:
    struct Due {
        CameraId camera{};
        std::int64_t sequence = 0;
    };
    struct Skipped {
        CameraId camera{};
        std::int64_t frames = 0;
        /// World time of the first one skipped, for those who ask whether anybody wanted it.
        TimeNs first_ns = 0;
        std::int64_t stride = 1;  ///< grid points from one to the next
    };

    /// The camera is due first at its first grid point after `after_ns`, with sequence number `first_sequence`.
    void set(CameraId camera, const camera::ExposureTimes& times, TimeNs after_ns, std::int64_t first_sequence);
    /// The camera, which was due just now, is due at every grid_points-th grid point (>= 1) from now on.
    void set_stride(CameraId camera, std::int64_t grid_points);
    std::int64_t stride(CameraId camera) const { return entries_.at(camera).stride; }
    void remove(CameraId camera) { entries_.erase(camera); }
    bool empty() const { return entries_.empty(); }

    /// The next instant at which anything is due; max_time_ns if there is no camera.
    TimeNs next_due_ns() const;
    TimeNs next_due_ns(CameraId camera) const;
    std::int64_t next_sequence(CameraId camera) const;
    const camera::ExposureTimes& times(CameraId camera) const { return entries_.at(camera).times; }

    /// The cameras due exactly at world_ns, in the order of their ids; they move on to their next frame.
    std::vector<Due> take(TimeNs world_ns);

    /// Under overload (policy drop): the instant to draw next among those due up to now_ns, namely the oldest one that
    /// is some camera's newest. Everything before it is superseded: each camera due there is due again already. So
    /// instants are dropped as a whole, a camera never loses its newest frame, a slow camera never suffers for a fast
    /// one, and none starves.
    TimeNs choose_instant(TimeNs now_ns) const;
    /// Moves every camera on to its first frame at or after world_ns; returns what each one skipped.
    std::vector<Skipped> skip_before(TimeNs world_ns);

private:
    struct Entry {
        camera::ExposureTimes times;
        std::int64_t next = 0;      ///< grid index of the next due frame
        std::int64_t sequence = 0;  ///< of that
        std::int64_t stride = 1;
        TimeNs next_ns() const { return times.time_of_frame(next); }
    };
    std::map<CameraId, Entry> entries_;
};

}  // namespace camrig::engine
