#pragma once

#include <optional>

#include <gst/gst.h>
#include <gst/rtp/gstrtpbuffer.h>

#include "rtsp_out/rtsp/annex_b.h"

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

/// Whether a key picture begins with this RTP packet: with its parameter sets, which our payloaders send before each,
/// alone or in an aggregation packet (RFC 6184, 5.6 and 5.7.1; RFC 7798, 4.4.1 and 4.4.2).
inline bool begins_key_picture(GstBuffer* packet, NalCodec codec) {
    constexpr guint8 h264_aggregation = 24, h264_sps = 7, h265_aggregation = 48, h265_vps = 32;
    const bool is_h264 = codec == NalCodec::h264;
    const guint8 aggregation = is_h264 ? h264_aggregation : h265_aggregation;
    const guint8 parameters = is_h264 ? h264_sps : h265_vps;
    GstRTPBuffer rtp = GST_RTP_BUFFER_INIT;
    if (!gst_rtp_buffer_map(packet, GST_MAP_READ, &rtp)) return false;
    const std::span payload(static_cast<const guint8*>(gst_rtp_buffer_get_payload(&rtp)),
                            gst_rtp_buffer_get_payload_len(&rtp));
    const auto type_at = [&](std::size_t at) { return Nal{.first_byte = payload[at]}.type(codec); };
    bool begins = !payload.empty() && type_at(0) == parameters;
    if (!payload.empty() && type_at(0) == aggregation) {
        // Behind the aggregation's own header, each unit comes after its size in two bytes.
        for (std::size_t at = is_h264 ? 1 : 2; at + 2 < payload.size() && !begins;
             at += 2 + (std::size_t{payload[at]} << 8 | payload[at + 1]))
            begins = type_at(at + 2) == parameters;
    }
    gst_rtp_buffer_unmap(&rtp);
    return begins;
}

}  // namespace camrig::rtsp
