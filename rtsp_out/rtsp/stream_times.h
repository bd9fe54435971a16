#pragma once

#include <optional>

#include "core/frame/frame.h"
#include "rtsp_out/rtsp/rtp_timeline.h"

namespace camrig::rtsp {

/// The PTS of a stream's pictures and the times in its RTCP sender reports, by the simulated clock of its camera, which
/// may run wrong and may be added or removed at any time. Of a camera with a sensor a picture's time is the start of
/// its exposure. PTS strictly increase, by at least a tick of the RTP clock.
///
/// Plain arithmetic, reads no clock. One thread at a time.
class StreamTimes {
public:
    explicit StreamTimes(const RtpTimeline& timeline) : timeline_(timeline) {}

    /// The PTS of the next picture; stamp_ns: its timestamp by PictureStamps, CLOCK_MONOTONIC.
    TimeNs next_pts(const frame::FrameInfo& info, TimeNs stamp_ns);
    /// The times of a sender report made now.
    RtpTimeline::SenderTime sender_time(TimeNs now_ns) const { return timeline_.sender_time(now_ns, clock_); }

private:
    /// Two pictures never share a tick of the RTP clock.
    static constexpr TimeNs min_step_ns = ns_per_s / RtpTimeline::ticks_per_s + 1;

    const RtpTimeline timeline_;
    StreamClock clock_;                           ///< at the last picture
    std::optional<TimeNs> first_clock_error_ns_;  ///< at the first one, where RTP time is right
    TimeNs last_pts_ = -min_step_ns;
    bool had_clock_ = false;    ///< the camera, at the last picture
    TimeNs last_world_ns_ = 0;  ///< of it
};

}  // namespace camrig::rtsp
