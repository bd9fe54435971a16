#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <linux/videodev2.h>

#include "core/stream/frame_bus.h"
#include "v4l2_sink/loopback/loopback_output.h"

namespace camrig::device {

/// What a loopback device shows: one format, one size, one rate, for all its readers.
struct LoopbackFormat {
    std::uint32_t fourcc = V4L2_PIX_FMT_YUYV;
    ImageSize size;
    Rate rate;
    codec::ChromaSampling mjpg_sampling = codec::ChromaSampling::yuv422;  ///< of MJPG; the kernel knows nothing of it

    /// "YUYV 640x480".
    std::string to_string() const;
    bool same_pictures(const LoopbackFormat& other) const { return fourcc == other.fourcc && size == other.size; }
    friend bool operator==(const LoopbackFormat&, const LoopbackFormat&) = default;
};

/// The format of an output of this camera, whose width and height are even.
LoopbackFormat loopback_format_of(const stream::CameraStream& camera, const LoopbackOutput& output);
/// In which form the bus gives pictures of this format; nothing for a fourcc that is none of ours.
std::optional<stream::MediaFormat> media_format_of(const LoopbackFormat& format);
/// How V4L2 says it, with BT.601 limited range (MJPG: JFIF; BGR3: full range) in the colour fields.
v4l2_pix_format pix_format_of(const LoopbackFormat& format);

}  // namespace camrig::device
