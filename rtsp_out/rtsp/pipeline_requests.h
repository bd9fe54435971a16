#pragma once

#include <gst/gst.h>

/// What the elements of a stream's pipeline are asked for while it runs. Any thread.
namespace camrig::rtsp {

/// The next picture of an encoder is a key frame. Null: nothing, for each JPEG is one.
void request_key_frame(GstElement* encoder);

/// RTP goes on as another source: a payloader draws itself another SSRC.
void change_ssrc(GstElement* payloader);

}  // namespace camrig::rtsp
