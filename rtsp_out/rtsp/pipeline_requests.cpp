#include "rtsp_out/rtsp/pipeline_requests.h"

#include <gst/video/video.h>

#include "rtsp_out/rtsp/gst_handle.h"

namespace camrig::rtsp {

void request_key_frame(GstElement* encoder) {
    if (encoder == nullptr) return;
    const GObjectHandle<GstPad> pad(gst_element_get_static_pad(encoder, "src"));
    gst_pad_send_event(pad.get(), gst_video_event_new_upstream_force_key_unit(GST_CLOCK_TIME_NONE, FALSE, 0));
}

void change_ssrc(GstElement* payloader) {
    // A payloader takes another one at random when it is told that somebody else has its own (RFC 3550, 8.2).
    const GObjectHandle<GstPad> pad(gst_element_get_static_pad(payloader, "src"));
    GstStructure* stats = nullptr;
    guint ssrc = 0;
    g_object_get(payloader, "stats", &stats, nullptr);
    if (stats == nullptr) return;
    const bool is_known = gst_structure_get_uint(stats, "ssrc", &ssrc) != 0;
    gst_structure_free(stats);
    if (!is_known) return;
    gst_pad_send_event(pad.get(),
                       gst_event_new_custom(GST_EVENT_CUSTOM_UPSTREAM,
                                            gst_structure_new("GstRTPCollision", "ssrc", G_TYPE_UINT, ssrc, nullptr)));
}

}  // namespace camrig::rtsp
