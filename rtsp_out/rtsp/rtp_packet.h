#pragma once

#include <optional>

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

/// The sequence number of an RTP packet (RFC 3550, 5.1); nothing of RTCP or what is too short.
inline std::optional<guint16> rtp_sequence(GstBuffer* packet) {
    guint8 head[4] = {};
    if (gst_buffer_extract(packet, 0, head, sizeof head) != sizeof head || is_rtcp(packet)) return std::nullopt;
    return static_cast<guint16>(head[2] << 8 | head[3]);
}

}  // namespace camrig::rtsp
