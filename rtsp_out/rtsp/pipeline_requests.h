#pragma once

#include <gst/gst.h>

/// Requests to the elements of a running pipeline. Any thread.
namespace camrig::rtsp {

/// Makes the encoder's next picture a key frame. Null (JPEG): does nothing.
void request_key_frame(GstElement* encoder);

/// Makes the payloader go on with another, random SSRC.
void change_ssrc(GstElement* payloader);

}  // namespace camrig::rtsp
