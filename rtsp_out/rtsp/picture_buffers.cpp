#include "rtsp_out/rtsp/picture_buffers.h"

#include <gst/video/video.h>

namespace camrig::rtsp {

GstCapsHandle caps_of(const stream::MediaFormat& format, ImageSize size, const Rate& rate) {
    GstCaps* caps = nullptr;
    if (format.codec == codec::Codec::jpeg) {
        caps = gst_caps_new_empty_simple("image/jpeg");
    } else {
        // sRGB pictures (BT.709 primaries, sRGB transfer) through the BT.601 matrix in limited range, chroma in the
        // middle of its pixels: core/frame/convert.h. BT.601 at every size, for many programs never read the
        // description.
        caps = gst_caps_new_simple("video/x-raw", "format", G_TYPE_STRING,
                                   format.pixels == frame::PixelFormat::nv12 ? "NV12" : "I420", "colorimetry",
                                   G_TYPE_STRING, "2:4:7:1", "chroma-site", G_TYPE_STRING, "jpeg", "interlace-mode",
                                   G_TYPE_STRING, "progressive", nullptr);
    }
    gst_caps_set_simple(caps, "width", G_TYPE_INT, size.width, "height", G_TYPE_INT, size.height, "framerate",
                        GST_TYPE_FRACTION, static_cast<int>(rate.num()), static_cast<int>(rate.den()), nullptr);
    return GstCapsHandle(caps);
}

GstBufferHandle buffer_of(const stream::MediaUnit& unit, const stream::MediaFormat& format, ImageSize shown) {
    if (unit.bytes) return wrapped(unit.bytes->data(), unit.bytes->size(), unit.bytes);
    const frame::FrameRef& frame = unit.frame;
    GstBufferHandle buffer = wrapped(frame->bytes().data(), frame->bytes().size(), frame);
    // Our rows are not padded, and an odd last column or row is left out: pixel (x, y) stays pixel (x, y).
    const auto width = static_cast<gsize>(unit.info.size.width), height = static_cast<gsize>(unit.info.size.height);
    const gsize half_width = (width + 1) / 2, half_height = (height + 1) / 2;
    const bool nv12 = format.pixels == frame::PixelFormat::nv12;
    gsize offsets[GST_VIDEO_MAX_PLANES] = {0, width * height, width * height + half_width * half_height};
    gint strides[GST_VIDEO_MAX_PLANES] = {
        static_cast<gint>(width), static_cast<gint>(nv12 ? 2 * half_width : half_width), static_cast<gint>(half_width)};
    gst_buffer_add_video_meta_full(
        buffer.get(), GST_VIDEO_FRAME_FLAG_NONE, nv12 ? GST_VIDEO_FORMAT_NV12 : GST_VIDEO_FORMAT_I420,
        static_cast<guint>(shown.width), static_cast<guint>(shown.height), nv12 ? 2 : 3, offsets, strides);
    return buffer;
}

}  // namespace camrig::rtsp
