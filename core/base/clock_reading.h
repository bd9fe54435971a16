#pragma once

#include <cstdint>

#include "core/base/time.h"

namespace camrig {

/// What a camera's own clock says at one instant, against the true time: added to a true time of that instant, on
/// whatever time base, it is what the camera says. Of a picture the instant is that of its stamp.
struct ClockReading {
    TimeNs stamp_error_ns = 0;   ///< of its time of day, which can be set: pictures are stamped with it
    TimeNs steady_error_ns = 0;  ///< of its monotonic clock: the same without what the time was stepped by since
    std::int64_t drift_ppb = 0;  ///< by so much both run fast now, but for what is random from picture to picture
    friend bool operator==(const ClockReading&, const ClockReading&) = default;
};

}  // namespace camrig
