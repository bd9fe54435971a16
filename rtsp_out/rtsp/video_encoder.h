#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/frame/pixel_format.h"
#include "rtsp_out/rtsp/rtsp_output.h"

namespace camrig::rtsp {

/// An encoder as a piece of a GStreamer pipeline.
struct VideoEncoder {
    std::string element;                                   ///< e.g. "x264enc"
    std::string launch;                                    ///< "x264enc name=enc ... ! video/x-h264,..."
    frame::PixelFormat pixels = frame::PixelFormat::i420;  ///< what it takes: i420 or nv12
};

/// In order of preference: hardware first.
inline const std::vector<std::string> h264_elements = {"nvh264enc", "vah264enc", "x264enc", "openh264enc"};

/// For H.264 the first of `elements` that GStreamer has, for H.265 x265enc; set up for the least latency: no
/// reordering, no look-ahead, every picture comes out as soon as it went in. unsupported: none is installed.
Result<VideoEncoder> choose_video_encoder(const std::vector<std::string>& elements, const StreamSettings& stream);

/// Whether GStreamer, which must have been initialised, has x265enc.
bool has_h265_encoder();

}  // namespace camrig::rtsp
