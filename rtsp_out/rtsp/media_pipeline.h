#pragma once

#include <functional>

#include <gst/gst.h>

#include "rtsp_out/rtsp/rtp_timeline.h"

namespace camrig::rtsp {

/// What the pipeline asks on its streaming threads before packets go to the readers.
struct PipelineQuestions {
    std::function<bool()> tcp_readers_take;  ///< false: RTP packets to TCP clients are dropped
    std::function<bool()> is_lockstep;       ///< yes: nothing may keep a picture once it is sent
    std::function<RtpTimeline::SenderTime(TimeNs now_ns)> sender_time;  ///< for a report that goes now
};

/// Sets a media's pipeline up before it runs: CLOCK_MONOTONIC from base_ns on is its time, no sink waits or keeps
/// pictures, a stuck client holds nobody up, and sender reports come early and say what they are told to.
///
/// gst-rtsp-server makes most of the elements later; they are caught as they are added.
void set_up_media_pipeline(GstPipeline* pipeline, TimeNs base_ns, PipelineQuestions questions);

}  // namespace camrig::rtsp
