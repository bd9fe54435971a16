#pragma once

#include <cstdint>
#include <optional>

#include <linux/videodev2.h>

#include "core/base/field.h"
#include "core/stream/frame_bus.h"

namespace camrig::device {

/// Options that both kinds of V4L2 output have: devices of the kernel module v4l2loopback and those in user space.
inline Field video_number_field() {
    return {.name = "number", .doc = "N of /dev/videoN", .required = true, .range = {0, 255}};
}
/// Chroma subsampling of MJPG. The default is 4:2:2: most webcams send that, and some readers (guvcview) take it for
/// granted.
inline Field subsampling_field(std::string option = {}) {
    return {.name = "subsampling", .doc = "chroma of MJPG", .option = std::move(option)};
}

/// The format to subscribe to on the frame bus for frames of this V4L2 pixel format and size; nullopt for a pixel
/// format that camrig does not offer.
inline std::optional<stream::MediaFormat> media_format_of(std::uint32_t fourcc, ImageSize size,
                                                          codec::ChromaSampling mjpg_sampling) {
    stream::MediaFormat media;
    media.size = size;
    switch (fourcc) {
        case V4L2_PIX_FMT_YUYV:
            media.pixels = frame::PixelFormat::yuyv;
            return media;
        case V4L2_PIX_FMT_YUV420:
            media.pixels = frame::PixelFormat::i420;
            return media;
        case V4L2_PIX_FMT_NV12:
            media.pixels = frame::PixelFormat::nv12;
            return media;
        case V4L2_PIX_FMT_BGR24:
            media.pixels = frame::PixelFormat::bgr24;
            return media;
        case V4L2_PIX_FMT_MJPEG:
            media.codec = codec::Codec::jpeg;
            media.quality = codec::default_jpeg_quality;
            media.sampling = mjpg_sampling;
            return media;
        default:
            return std::nullopt;
    }
}

}  // namespace camrig::device
