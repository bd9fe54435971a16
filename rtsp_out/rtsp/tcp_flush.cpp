#include "rtsp_out/rtsp/tcp_flush.h"

#include <utility>

#include "rtsp_out/rtsp/rtp_packet.h"

namespace camrig::rtsp {
namespace {

/// The chain functions of an appsink, as they were.
struct SinkChain {
    std::function<bool()> wanted;
    GstPadChainFunction single;
    GstPadChainListFunction list;
};
constexpr const char* chain_key = "camrig-chain";

const SinkChain& chain_of(GstPad* pad) {
    return *static_cast<const SinkChain*>(g_object_get_data(G_OBJECT(pad), chain_key));
}

/// What comes after the last packet of a picture. Its stamp is the packet's: gst-rtsp-server aborts on one without.
GstBuffer* flush_buffer_after(GstBuffer* packet) {
    GstBuffer* flush = gst_buffer_new();
    GST_BUFFER_PTS(flush) = GST_BUFFER_PTS(packet);
    GST_BUFFER_DTS(flush) = GST_BUFFER_DTS(packet);
    return flush;
}

GstFlowReturn chain_list(GstPad* pad, GstObject* parent, GstBufferList* packets) {
    const SinkChain& chain = chain_of(pad);
    const guint count = gst_buffer_list_length(packets);
    GstBuffer* last = count > 0 ? gst_buffer_list_get(packets, count - 1) : nullptr;
    GstBuffer* flush = last && ends_picture(last) && chain.wanted() ? flush_buffer_after(last) : nullptr;
    const GstFlowReturn flow = chain.list(pad, parent, packets);
    if (flush && flow == GST_FLOW_OK) return chain.single(pad, parent, flush);
    if (flush) gst_buffer_unref(flush);
    return flow;
}

GstFlowReturn chain_single(GstPad* pad, GstObject* parent, GstBuffer* packet) {
    GstBufferList* packets = gst_buffer_list_new_sized(1);
    gst_buffer_list_add(packets, packet);
    return chain_list(pad, parent, packets);
}

/// In the place of what writes a single buffer. A flush buffer counts as written at once, which lets what waits behind
/// it go on. Any other buffer goes the way of lists; there is one for each TCP reader (rtsp-client.c).
template <gboolean (*send_list)(GstRTSPStreamTransport*, GstBufferList*)>
gboolean send_single(GstBuffer* buffer, guint8, void* data) {
    auto* const transport = GST_RTSP_STREAM_TRANSPORT(data);
    if (gst_buffer_get_size(buffer) == 0) {
        gst_rtsp_stream_transport_message_sent(transport);
        return TRUE;
    }
    GstBufferList* packets = gst_buffer_list_new_sized(1);
    gst_buffer_list_add(packets, gst_buffer_ref(buffer));
    const gboolean sent = send_list(transport, packets);
    gst_buffer_list_unref(packets);
    return sent;
}

}  // namespace

void send_flush_buffers(GstPad* pad, std::function<bool()> wanted) {
    auto* const chain = new SinkChain{std::move(wanted), GST_PAD_CHAINFUNC(pad), GST_PAD_CHAINLISTFUNC(pad)};
    g_object_set_data_full(G_OBJECT(pad), chain_key, chain, [](void* done) { delete static_cast<SinkChain*>(done); });
    gst_pad_set_chain_function(pad, chain_single);
    gst_pad_set_chain_list_function(pad, chain_list);
}

void drop_flush_buffers(GstRTSPStreamTransport* transport) {
    gst_rtsp_stream_transport_set_callbacks(transport, send_single<gst_rtsp_stream_transport_send_rtp_list>,
                                            send_single<gst_rtsp_stream_transport_send_rtcp_list>, transport, nullptr);
}

}  // namespace camrig::rtsp
