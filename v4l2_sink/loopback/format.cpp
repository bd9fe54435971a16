#include "v4l2_sink/loopback/format.h"

#include "v4l2_sink/media_format.h"

namespace camrig::device {

std::string LoopbackFormat::to_string() const {
    std::string name;
    for (int shift = 0; shift < 32; shift += 8) name += static_cast<char>(fourcc >> shift & 0xff);
    return name + " " + size.to_string();
}

LoopbackFormat loopback_format_of(const stream::CameraStream& camera, const LoopbackOutput& output) {
    LoopbackFormat format{V4L2_PIX_FMT_YUYV, camera.size, camera.rate, output.subsampling};
    if (output.format == "YU12") format.fourcc = V4L2_PIX_FMT_YUV420;
    if (output.format == "MJPG") format.fourcc = V4L2_PIX_FMT_MJPEG;
    if (output.format == "BGR3") format.fourcc = V4L2_PIX_FMT_BGR24;
    return format;
}

std::optional<stream::MediaFormat> media_format_of(const LoopbackFormat& format) {
    // NV12 is not offered here: OpenCV up to 4.10 swaps its red and blue.
    if (format.fourcc == V4L2_PIX_FMT_NV12) return std::nullopt;
    // Its own size, even when the camera's changes while it is read.
    return media_format_of(format.fourcc, format.size, format.mjpg_sampling);
}

v4l2_pix_format pix_format_of(const LoopbackFormat& format) {
    v4l2_pix_format pix{};
    pix.width = static_cast<std::uint32_t>(format.size.width);
    pix.height = static_cast<std::uint32_t>(format.size.height);
    pix.pixelformat = format.fourcc;
    pix.field = V4L2_FIELD_NONE;
    pix.priv = V4L2_PIX_FMT_PRIV_MAGIC;  // else the kernel ignores the fields after it
    pix.colorspace = V4L2_COLORSPACE_SRGB;
    pix.xfer_func = V4L2_XFER_FUNC_SRGB;
    pix.ycbcr_enc = V4L2_YCBCR_ENC_601;
    pix.quantization = V4L2_QUANTIZATION_LIM_RANGE;
    if (format.fourcc == V4L2_PIX_FMT_MJPEG) {
        pix.colorspace = V4L2_COLORSPACE_JPEG;
        pix.quantization = V4L2_QUANTIZATION_FULL_RANGE;
    } else if (format.fourcc == V4L2_PIX_FMT_BGR24) {
        pix.ycbcr_enc = V4L2_YCBCR_ENC_DEFAULT;
        pix.quantization = V4L2_QUANTIZATION_FULL_RANGE;
    }
    return pix;
}

}  // namespace camrig::device
