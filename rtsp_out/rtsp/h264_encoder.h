#pragma once

#include <string>
#include <vector>

#include "core/base/image_size.h"
#include "core/base/rate.h"
#include "core/base/result.h"
#include "core/frame/pixel_format.h"
#include "rtsp_out/rtsp/rtsp_output.h"

namespace camrig::rtsp {

/// 0.15 bits per pixel, at least 200 kbit/s: 1.2 Mbit/s for 640x480 at 25, 7.8 Mbit/s for 1920x1080 at 25.
int default_bitrate_kbps(ImageSize size, const Rate& rate);

/// An encoder as a piece of a GStreamer pipeline.
struct H264Encoder {
    std::string element;                                   ///< e.g. "x264enc"
    std::string launch;                                    ///< "x264enc name=enc ... ! video/x-h264,..."
    frame::PixelFormat pixels = frame::PixelFormat::i420;  ///< what it takes: i420 or nv12
};

/// In order of preference: hardware first.
inline const std::vector<std::string> h264_elements = {"nvh264enc", "vah264enc", "x264enc", "openh264enc"};

/// The first of `elements` that GStreamer has, set up for the least latency: no reordering, no look-ahead, every
/// picture comes out as soon as it went in. unsupported: none is installed.
Result<H264Encoder> choose_h264_encoder(const std::vector<std::string>& elements, const RtspOutput& options,
                                        ImageSize size, const Rate& rate);

}  // namespace camrig::rtsp
