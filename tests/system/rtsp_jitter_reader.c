// What GStreamer's own receiver counts of the RTP packets of a stream.
//
//     rtsp_jitter_reader URL
//
// Writes "playing" when the first packet has come and, when the stream ends, "num-pushed num-lost num-late" of its
// rtpjitterbuffer. Exit status 0.
#include <gst/gst.h>
#include <stdio.h>

static GMainLoop* loop;
static GstElement* buffer;

static void keep_buffer(GstElement* bin, GstElement* made, guint session, guint ssrc, gpointer data) {
    (void)bin, (void)session, (void)ssrc, (void)data;
    gst_object_replace((GstObject**)&buffer, GST_OBJECT(made));
}

static void follow_manager(GstElement* source, GstElement* manager, gpointer data) {
    (void)source, (void)data;
    g_signal_connect(manager, "new-jitterbuffer", G_CALLBACK(keep_buffer), NULL);
}

static void say_playing(GstElement* sink, GstBuffer* packet, GstPad* pad, gpointer data) {
    static gint said;
    (void)sink, (void)packet, (void)pad, (void)data;
    if (!g_atomic_int_exchange(&said, 1)) puts("playing"), fflush(stdout);
}

static gboolean end(GstBus* bus, GstMessage* message, gpointer data) {
    (void)bus, (void)data;
    const GstMessageType type = GST_MESSAGE_TYPE(message);
    if (type == GST_MESSAGE_EOS || type == GST_MESSAGE_ERROR) g_main_loop_quit(loop);
    return TRUE;
}

int main(int argc, char** argv) {
    gst_init(&argc, &argv);
    if (argc != 2) return 2;
    GstElement* pipeline = gst_parse_launch(
        "rtspsrc name=source protocols=tcp latency=200 ! fakesink name=sink sync=false signal-handoffs=true", NULL);
    if (!pipeline) return 1;
    GstElement* source = gst_bin_get_by_name(GST_BIN(pipeline), "source");
    GstElement* sink = gst_bin_get_by_name(GST_BIN(pipeline), "sink");
    g_object_set(source, "location", argv[1], NULL);
    g_signal_connect(source, "new-manager", G_CALLBACK(follow_manager), NULL);
    g_signal_connect(sink, "handoff", G_CALLBACK(say_playing), NULL);
    loop = g_main_loop_new(NULL, FALSE);
    GstBus* bus = gst_pipeline_get_bus(GST_PIPELINE(pipeline));
    gst_bus_add_watch(bus, end, NULL);
    gst_element_set_state(pipeline, GST_STATE_PLAYING);
    g_main_loop_run(loop);
    GstStructure* stats = NULL;
    if (buffer) g_object_get(buffer, "stats", &stats, NULL);
    guint64 pushed = 0, lost = 0, late = 0;
    if (stats && gst_structure_get(stats, "num-pushed", G_TYPE_UINT64, &pushed, "num-lost", G_TYPE_UINT64, &lost,
                                   "num-late", G_TYPE_UINT64, &late, NULL))
        printf("%" G_GUINT64_FORMAT " %" G_GUINT64_FORMAT " %" G_GUINT64_FORMAT "\n", pushed, lost, late);
    gst_element_set_state(pipeline, GST_STATE_NULL);
    return 0;
}
