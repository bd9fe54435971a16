#pragma once

#include <optional>

#include "core/base/time.h"

namespace camrig::probe {

/// Tells when a source has handed out what had piled up while it was being opened (a decoder is looked for meanwhile),
/// so that a rate counts pictures as they come: 28 pictures of the first second are no rate of 28.
///
/// Pictures of a burst come faster than they were taken. Plain arithmetic, reads no clock.
class FirstBurst {
public:
    /// A source whose stamps mean something else is measured all the same.
    static constexpr TimeNs max_ns = 2 * ns_per_s;

    /// To be asked for each picture in its turn. True from the first one that took at least half as long to come as it
    /// was taken after the one before; at once for a source without stamps.
    bool is_over(TimeNs arrival_ns, std::optional<TimeNs> stamp_ns) {
        if (over_ || !stamp_ns) return over_ = true;
        if (begun_ns_) {
            const TimeNs taken_ns = *stamp_ns - last_stamp_ns_, came_ns = arrival_ns - last_arrival_ns_;
            over_ = taken_ns <= 0 || 2 * came_ns >= taken_ns || arrival_ns - *begun_ns_ > max_ns;
        } else {
            begun_ns_ = arrival_ns;
        }
        last_arrival_ns_ = arrival_ns;
        last_stamp_ns_ = *stamp_ns;
        return over_;
    }

private:
    bool over_ = false;
    std::optional<TimeNs> begun_ns_;
    TimeNs last_arrival_ns_ = 0, last_stamp_ns_ = 0;
};

}  // namespace camrig::probe
