#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/base/time.h"

namespace camrig::camera {

/// A value as a function of world time: it stays what it is, or goes to another in a given time.
///
/// Segments are closed forms in integer nanoseconds: any time can be asked for, in any order, with the same answer, and
/// a command changes nothing of what was before it. Between two values it goes as between(from, to, share) of T says,
/// share from 0 to 1 by time. A value type; any thread.
template <typename T>
class Timeline {
public:
    /// So much of the past is kept; before that it is what it was at the oldest segment's begin.
    static constexpr TimeNs kept_ns = 250 * ns_per_ms;
    /// More commands than this within kept_ns shorten the past.
    static constexpr std::size_t max_segments = 64;

    explicit Timeline(const T& value) : segments_{{0, 0, value, value}} {}

    T at(TimeNs world_ns) const {
        const auto next = std::ranges::upper_bound(segments_, world_ns, {}, &Segment::begin_ns);
        return (next == segments_.begin() ? *next : *std::prev(next)).at(world_ns);
    }

    /// From begin_ns on it goes to `value`, where it is after duration_ns (0: at once). What was to come at begin_ns or
    /// later is given up.
    void go_to(const T& value, TimeNs begin_ns, TimeNs duration_ns) {
        const Segment added{begin_ns, begin_ns + duration_ns, at(begin_ns), value};
        const auto given_up = std::ranges::lower_bound(segments_, begin_ns, {}, &Segment::begin_ns);
        segments_.erase(given_up, segments_.end());
        segments_.push_back(added);
        // The second must have begun before what is kept, or the first is still needed.
        while (segments_.size() > max_segments || (segments_.size() > 1 && segments_[1].begin_ns <= begin_ns - kept_ns))
            segments_.erase(segments_.begin());
    }

    /// From then on it stays what it is.
    TimeNs arrives_ns() const { return segments_.back().end_ns; }

private:
    struct Segment {
        TimeNs begin_ns = 0, end_ns = 0;
        T from, to;

        T at(TimeNs world_ns) const {
            if (world_ns >= end_ns) return to;
            if (world_ns <= begin_ns) return from;
            return between(from, to, static_cast<double>(world_ns - begin_ns) / static_cast<double>(end_ns - begin_ns));
        }
    };
    std::vector<Segment> segments_;  ///< by begin_ns; never empty
};

}  // namespace camrig::camera
