#pragma once

#include <functional>

#include <gst/gst.h>

#include "rtsp_out/rtsp/rtp_timeline.h"

namespace camrig::rtsp {

/// What the pipeline needs to know when it sends. Called on its streaming threads.
struct PipelineQuestions {
    std::function<bool()> tcp_readers_take;  ///< false: RTP packets to TCP clients are dropped
    std::function<bool()> is_lockstep;       ///< true: no element may keep a picture once it is sent
    std::function<RtpTimeline::SenderTime(TimeNs now_ns)> sender_time;  ///< of an RTCP sender report made now
};

/// Configures a media's pipeline before it runs: its clock is CLOCK_MONOTONIC with base time base_ns, sinks neither
/// synchronise to it nor keep the last sample, blocked TCP clients do not block it, and RTCP sender reports
/// come every 0.1 to 0.3 s with the times of `sender_time`.
///
/// gst-rtsp-server makes most of the elements later; they are configured as they are added.
void set_up_media_pipeline(GstPipeline* pipeline, TimeNs base_ns, PipelineQuestions questions);

}  // namespace camrig::rtsp
