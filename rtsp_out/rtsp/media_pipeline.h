#pragma once

#include <functional>

#include <gst/gst.h>

#include "rtsp_out/rtsp/rtp_timeline.h"

namespace camrig::rtsp {

/// What the pipeline asks on its streaming threads before RTP packets go to the TCP readers.
struct PipelineQuestions {
    std::function<bool()> tcp_readers_take;  ///< false: RTP packets to TCP clients are dropped
    std::function<bool()> is_lockstep;       ///< yes: nothing may keep a picture once it is sent
};

/// Sets a media's pipeline up before it runs: its clock and base time are the timeline's, no sink waits or keeps
/// pictures, a stuck client holds nobody up, and sender reports come early and say what the timeline says.
///
/// gst-rtsp-server makes most of the elements later; they are caught as they are added.
void set_up_media_pipeline(GstPipeline* pipeline, const RtpTimeline& timeline, PipelineQuestions questions);

}  // namespace camrig::rtsp
