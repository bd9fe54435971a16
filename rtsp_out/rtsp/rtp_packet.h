#pragma once

#include <gst/gst.h>

namespace camrig::rtsp {

/// Whether this is RTCP: its second byte is a packet type of 192 to 223, which no RTP packet has there (RFC 5761, 4).
inline bool is_rtcp(GstBuffer* packet) {
    guint8 head[2] = {};
    return gst_buffer_extract(packet, 0, head, sizeof head) == sizeof head && head[1] >= 192 && head[1] <= 223;
}

/// Whether this is the last RTP packet of a picture: it has the marker bit.
inline bool ends_picture(GstBuffer* packet) {
    guint8 head[2] = {};
    return gst_buffer_extract(packet, 0, head, sizeof head) == sizeof head && (head[1] & 0x80) != 0 && !is_rtcp(packet);
}

}  // namespace camrig::rtsp
