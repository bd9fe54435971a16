#include "rtsp_out/rtsp/media_pipeline.h"

#include <memory>
#include <string_view>

#include <gst/rtp/gstrtcpbuffer.h>

#include "core/base/clock.h"
#include "rtsp_out/rtsp/gst_handle.h"
#include "rtsp_out/rtsp/rtp_packet.h"
#include "rtsp_out/rtsp/tcp_reader.h"

namespace camrig::rtsp {
namespace {

/// Reports come every 0.1 to 0.3 s (RFC 3550 randomises around this, and the first one comes after half of it).
constexpr guint64 report_interval_ns = 250 * ns_per_ms;
/// What an element that gst-rtsp-server adds may need.
using SetupRef = std::shared_ptr<const PipelineQuestions>;

/// User data of a signal or probe, freed with it.
SetupRef* kept(const SetupRef& setup) {
    return new SetupRef(setup);
}
void free_kept(void* setup) {
    delete static_cast<SetupRef*>(setup);
}
void free_with_closure(void* setup, GClosure*) {
    free_kept(setup);
}
const PipelineQuestions& questions_of(void* kept_setup) {
    return **static_cast<SetupRef*>(kept_setup);
}

bool is_made_by(GstElement* element, std::string_view factory_name) {
    GstElementFactory* factory = gst_element_get_factory(element);
    return factory && factory_name == gst_plugin_feature_get_name(GST_PLUGIN_FEATURE(factory));
}

/// Writes the stream's RTP time and absolute time into a sender report.
///
/// rtpsession's own are from two clocks read one after the other, and from the time of the last packet; on a busy
/// machine two streams disagree by what lies between.
GstPadProbeReturn rewrite_report(GstPad*, GstPadProbeInfo* info, void* setup) {
    GstBuffer* buffer = gst_buffer_make_writable(GST_PAD_PROBE_INFO_BUFFER(info));
    GST_PAD_PROBE_INFO_DATA(info) = buffer;
    GstRTCPBuffer rtcp = GST_RTCP_BUFFER_INIT;
    if (!gst_rtcp_buffer_map(buffer, GST_MAP_READWRITE, &rtcp)) return GST_PAD_PROBE_OK;
    GstRTCPPacket packet;
    for (gboolean more = gst_rtcp_buffer_get_first_packet(&rtcp, &packet); more;
         more = gst_rtcp_packet_move_to_next(&packet)) {
        if (gst_rtcp_packet_get_type(&packet) != GST_RTCP_TYPE_SR) continue;
        guint32 ssrc = 0, rtp = 0, packets = 0, octets = 0;
        guint64 ntp = 0;
        gst_rtcp_packet_sr_get_sender_info(&packet, &ssrc, &ntp, &rtp, &packets, &octets);
        const auto time = questions_of(setup).sender_time(monotonic_now_ns());
        gst_rtcp_packet_sr_set_sender_info(&packet, ssrc, time.ntp, time.rtp, packets, octets);
    }
    gst_rtcp_buffer_unmap(&rtcp);
    return GST_PAD_PROBE_OK;
}

void on_rtpbin_pad(GstElement*, GstPad* pad, void* setup) {
    if (!std::string_view(GST_PAD_NAME(pad)).starts_with("send_rtcp_src_")) return;
    gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, rewrite_report, kept(*static_cast<SetupRef*>(setup)), free_kept);
}

/// Reports are single packets; RTP comes in lists or singly.
bool is_report(GstPadProbeInfo* info) {
    return (GST_PAD_PROBE_INFO_TYPE(info) & GST_PAD_PROBE_TYPE_BUFFER) && is_rtcp(GST_PAD_PROBE_INFO_BUFFER(info));
}

GstPadProbeReturn leave_out_if_stuck(GstPad*, GstPadProbeInfo* info, void* setup) {
    return is_report(info) || questions_of(setup).tcp_readers_take() ? GST_PAD_PROBE_OK : GST_PAD_PROBE_DROP;
}

void on_element_added(GstBin*, GstBin*, GstElement* element, void* setup) {
    SetupRef& own = *static_cast<SetupRef*>(setup);
    if (is_made_by(element, "rtpbin")) {
        g_signal_connect_data(element, "pad-added", G_CALLBACK(on_rtpbin_pad), kept(own), free_with_closure,
                              GConnectFlags{});
    } else if (is_made_by(element, "rtpsession")) {
        g_object_set(element, "rtcp-min-interval", report_interval_ns, nullptr);
    } else if (is_made_by(element, "appsink") || is_made_by(element, "multiudpsink")) {
        // A kept last packet would keep its picture, and with it the latch of a step. Pictures go when they come.
        g_object_set(element, "sync", FALSE, "enable-last-sample", FALSE, nullptr);
        if (!is_made_by(element, "appsink")) return;
        // The way to the TCP readers. It blocks while all of them are stuck, and everybody's pictures with it.
        const GObjectHandle<GstPad> pad(gst_element_get_static_pad(element, "sink"));
        constexpr int packets = GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_BUFFER_LIST;
        gst_pad_add_probe(pad.get(), static_cast<GstPadProbeType>(packets), leave_out_if_stuck, kept(own), free_kept);
        carry_packets(pad.get(), [own] { return own->is_lockstep(); });
    }
}

}  // namespace

void set_up_media_pipeline(GstPipeline* pipeline, TimeNs base_ns, PipelineQuestions questions) {
    GstClock* clock = gst_system_clock_obtain();  // CLOCK_MONOTONIC, as the stamps of frames
    gst_pipeline_use_clock(pipeline, clock);
    gst_object_unref(clock);
    gst_element_set_start_time(GST_ELEMENT(pipeline), GST_CLOCK_TIME_NONE);  // the base time stays as it is
    gst_element_set_base_time(GST_ELEMENT(pipeline), static_cast<GstClockTime>(base_ns));
    const auto setup = std::make_shared<const PipelineQuestions>(std::move(questions));
    g_signal_connect_data(pipeline, "deep-element-added", G_CALLBACK(on_element_added), kept(setup), free_with_closure,
                          GConnectFlags{});
}

}  // namespace camrig::rtsp
