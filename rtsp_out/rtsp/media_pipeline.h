#pragma once

#include <functional>

#include <gst/gst.h>

#include "rtsp_out/rtsp/rtp_timeline.h"

namespace camrig {

/// Sets a media's pipeline up before it runs: its clock and base time are the timeline's, no sink waits or keeps
/// pictures, a stuck client holds nobody up, and sender reports come early and say what the timeline says.
///
/// gst-rtsp-server makes most of the elements later; they are caught as they are added.
/// `tcp_readers_take` is asked on streaming threads before RTP packets go to the TCP readers; packets are left out when
/// it says no.
void set_up_media_pipeline(GstPipeline* pipeline, const RtpTimeline& timeline, std::function<bool()> tcp_readers_take);

}  // namespace camrig
