#include "rtsp_out/rtsp/stream_times.h"

#include <algorithm>

namespace camrig::rtsp {

TimeNs StreamTimes::next_pts(const frame::FrameInfo& info, TimeNs stamp_ns) {
    const ClockReading reading = info.clock.value_or(ClockReading{});
    if (!first_clock_error_ns_) first_clock_error_ns_ = reading.steady_error_ns;
    // Where a clock is given or taken away, or begins anew in another world, RTP time goes on as if it had been so
    // before: it is steady, and its constant error is nobody's to see.
    const bool begins_anew = last_pts_ >= 0 && (had_clock_ != info.clock.has_value() || info.world_ns < last_world_ns_);
    had_clock_ = info.clock.has_value();
    last_world_ns_ = info.world_ns;
    if (begins_anew) first_clock_error_ns_ = reading.steady_error_ns - clock_.rtp_error_ns;
    clock_ = {.rtp_error_ns = reading.steady_error_ns - *first_clock_error_ns_, .ntp_error_ns = reading.stamp_error_ns};
    const TimeNs pts = timeline_.pts_of(stamp_ns - info.taken_for_ns()) + clock_.rtp_error_ns;
    return last_pts_ = std::max(pts, last_pts_ + min_step_ns);
}

}  // namespace camrig::rtsp
