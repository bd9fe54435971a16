#pragma once

#include <optional>

#include "core/frame/frame.h"
#include "rtsp_out/rtsp/rtp_timeline.h"

namespace camrig::rtsp {

/// The stream times (PTS) of a stream's pictures and what its sender reports say, by the clock of its camera, which may
/// run wrong, be given or taken away. Stream times strictly rise, by a tick of RTP's clock at least.
///
/// Plain arithmetic, reads no clock. One thread at a time.
class StreamTimes {
public:
    explicit StreamTimes(const RtpTimeline& timeline) : timeline_(timeline) {}

    /// Of the next picture; stamp_ns: CLOCK_MONOTONIC, of PictureStamps.
    TimeNs next_pts(const frame::FrameInfo& info, TimeNs stamp_ns);
    /// What a sender report that goes now says.
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
