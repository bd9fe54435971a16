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
    codec::ChromaSampling mjpg_sampling = codec::ChromaSampling::yuv422;  ///< of MJPG; not part of V4L2's format

    /// "YUYV 640x480".
    std::string to_string() const;
    bool same_pictures(const LoopbackFormat& other) const { return fourcc == other.fourcc && size == other.size; }
    friend bool operator==(const LoopbackFormat&, const LoopbackFormat&) = default;
};

/// The format of an output of this camera. The width and height of the camera must be even.
LoopbackFormat loopback_format_of(const stream::CameraStream& camera, const LoopbackOutput& output);
/// The format to subscribe to on the frame bus for frames of this format; nullopt for a fourcc that camrig does not
/// offer.
std::optional<stream::MediaFormat> media_format_of(const LoopbackFormat& format);
/// As VIDIOC_S_FMT takes it. Colour fields: BT.601, limited range; of MJPG those of JFIF, of BGR3 full range.
v4l2_pix_format pix_format_of(const LoopbackFormat& format);

}  // namespace camrig::device
