#include "rtsp_out/rtsp/tcp_reader.h"

#include <utility>

#include "rtsp_out/rtsp/rtp_packet.h"

namespace camrig::rtsp {
namespace {

/// The chain functions of an appsink, as they were.
struct SinkChain {
    std::function<bool()> is_flushed;
    GstPadChainFunction single;
    GstClockTime last_pts = GST_CLOCK_TIME_NONE;  ///< of the packets before; those of a picture share one
};
constexpr const char* chain_key = "camrig-chain";

SinkChain& chain_of(GstPad* pad) {
    return *static_cast<SinkChain*>(g_object_get_data(G_OBJECT(pad), chain_key));
}

/// Under which a carrier has its packets.
GQuark packets_quark() {
    static const GQuark quark = g_quark_from_static_string("camrig-packets");
    return quark;
}

/// Of a carrier: a picture begins with its packets. Marker bits do not tell: rtph265pay sets them within pictures too.
constexpr auto picture_begins = GST_BUFFER_FLAG_HEADER;

/// A buffer of no bytes. Its stamp is that of a packet: gst-rtsp-server aborts on one without.
GstBuffer* empty_buffer_like(GstBuffer* packet) {
    GstBuffer* empty = gst_buffer_new();
    GST_BUFFER_PTS(empty) = GST_BUFFER_PTS(packet);
    GST_BUFFER_DTS(empty) = GST_BUFFER_DTS(packet);
    return empty;
}

GstFlowReturn chain_list(GstPad* pad, GstObject* parent, GstBufferList* packets) {
    SinkChain& chain = chain_of(pad);
    const guint count = gst_buffer_list_length(packets);
    if (count == 0) {
        gst_buffer_list_unref(packets);
        return GST_FLOW_OK;
    }
    GstBuffer* const last = gst_buffer_list_get(packets, count - 1);
    GstBuffer* const flush = !is_rtcp(last) && chain.is_flushed() ? empty_buffer_like(last) : nullptr;
    GstBuffer* const carrier = empty_buffer_like(last);
    if (std::exchange(chain.last_pts, GST_BUFFER_PTS(last)) != GST_BUFFER_PTS(last))
        GST_BUFFER_FLAG_SET(carrier, picture_begins);
    gst_mini_object_set_qdata(GST_MINI_OBJECT_CAST(carrier), packets_quark(), packets,
                              reinterpret_cast<GDestroyNotify>(gst_buffer_list_unref));
    const GstFlowReturn flow = chain.single(pad, parent, carrier);
    if (flush && flow == GST_FLOW_OK) return chain.single(pad, parent, flush);
    if (flush) gst_buffer_unref(flush);
    return flow;
}

GstFlowReturn chain_single(GstPad* pad, GstObject* parent, GstBuffer* packet) {
    GstBufferList* packets = gst_buffer_list_new_sized(1);
    gst_buffer_list_add(packets, packet);
    return chain_list(pad, parent, packets);
}

/// One reader. Its transport outlives it: that owns it.
struct TcpReader {
    GstRTSPStreamTransport* transport = nullptr;
    std::optional<NalCodec> codec;
    bool waits_for_key = false;

    /// Do these packets go to it? If it waits, a key picture must begin with the first of them.
    bool takes(GstBuffer* carrier, GstBufferList* packets) {
        if (waits_for_key && GST_BUFFER_FLAG_IS_SET(carrier, picture_begins))
            waits_for_key = !begins_key_picture(gst_buffer_list_get(packets, 0), *codec);
        return !waits_for_key;
    }
};

/// What is not sent counts as written at once, which lets what waits behind it go on.
gboolean left_out(const TcpReader& reader) {
    gst_rtsp_stream_transport_message_sent(reader.transport);
    return TRUE;
}

GstBufferList* packets_of(GstBuffer* carrier) {
    return static_cast<GstBufferList*>(gst_mini_object_get_qdata(GST_MINI_OBJECT_CAST(carrier), packets_quark()));
}

gboolean send_rtp(GstBuffer* buffer, guint8, void* data) {
    auto& reader = *static_cast<TcpReader*>(data);
    GstBufferList* const packets = packets_of(buffer);
    if (packets == nullptr || !reader.takes(buffer, packets)) return left_out(reader);
    return gst_rtsp_stream_transport_send_rtp_list(reader.transport, packets);
}

gboolean send_rtcp(GstBuffer* buffer, guint8, void* data) {
    const auto& reader = *static_cast<TcpReader*>(data);
    GstBufferList* const packets = packets_of(buffer);
    return packets ? gst_rtsp_stream_transport_send_rtcp_list(reader.transport, packets) : left_out(reader);
}

}  // namespace

void carry_packets(GstPad* pad, std::function<bool()> is_flushed) {
    auto* const chain = new SinkChain{std::move(is_flushed), GST_PAD_CHAINFUNC(pad)};
    g_object_set_data_full(G_OBJECT(pad), chain_key, chain, [](void* done) { delete static_cast<SinkChain*>(done); });
    gst_pad_set_chain_function(pad, chain_single);
    gst_pad_set_chain_list_function(pad, chain_list);
}

void unpack_carriers(GstRTSPStreamTransport* transport, std::optional<NalCodec> codec) {
    auto* const reader = new TcpReader{transport, codec, codec.has_value()};
    gst_rtsp_stream_transport_set_callbacks(transport, send_rtp, send_rtcp, reader,
                                            [](void* done) { delete static_cast<TcpReader*>(done); });
}

}  // namespace camrig::rtsp
