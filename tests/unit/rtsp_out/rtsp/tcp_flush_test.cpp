#include "rtsp_out/rtsp/tcp_flush.h"

#include <gtest/gtest.h>

#include "rtsp_out/rtsp/gst_handle.h"

namespace camrig::rtsp {
namespace {

/// What a TCP reader is sent, and how many messages count as written.
struct Sent {
    int rtp_lists = 0, rtcp_lists = 0, written = 0;
    gsize bytes = 0;
};

class TcpReader : public testing::Test {
protected:
    static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

    void SetUp() override {
        payloader_.reset(GST_ELEMENT(gst_object_ref_sink(gst_element_factory_make("rtpjpegpay", nullptr))));
        const GObjectHandle<GstPad> pad(gst_element_get_static_pad(payloader_.get(), "src"));
        stream_.reset(gst_rtsp_stream_new(0, payloader_.get(), pad.get()));
        GstRTSPTransport* requested = nullptr;
        gst_rtsp_transport_new(&requested);
        transport_.reset(gst_rtsp_stream_transport_new(stream_.get(), requested));
        const auto count_rtp = +[](GstBufferList* packets, guint8, void* sent) -> gboolean {
            ++static_cast<Sent*>(sent)->rtp_lists;
            static_cast<Sent*>(sent)->bytes += gst_buffer_list_calculate_size(packets);
            return TRUE;
        };
        const auto count_rtcp = +[](GstBufferList*, guint8, void* sent) -> gboolean {
            ++static_cast<Sent*>(sent)->rtcp_lists;
            return TRUE;
        };
        gst_rtsp_stream_transport_set_list_callbacks(transport_.get(), count_rtp, count_rtcp, &sent_, nullptr);
        gst_rtsp_stream_transport_set_message_sent_full(
            transport_.get(), +[](GstRTSPStreamTransport*, void* sent) { ++static_cast<Sent*>(sent)->written; }, &sent_,
            nullptr);
        drop_flush_buffers(transport_.get());
    }

    GObjectHandle<GstElement> payloader_;
    GObjectHandle<GstRTSPStream> stream_;
    GObjectHandle<GstRTSPStreamTransport> transport_;
    Sent sent_;
};

TEST_F(TcpReader, AFlushBufferIsWrittenAtOnceAndReachesNobody) {
    GstBuffer* flush = gst_buffer_new();
    EXPECT_TRUE(gst_rtsp_stream_transport_send_rtp(transport_.get(), flush));
    gst_buffer_unref(flush);
    EXPECT_EQ(sent_.written, 1);
    EXPECT_EQ(sent_.rtp_lists + sent_.rtcp_lists, 0);
}

// GStreamer may send single buffers where it sent lists; that ended the daemon.
TEST_F(TcpReader, ASinglePacketGoesTheWayOfLists) {
    GstBuffer* packet = gst_buffer_new_allocate(nullptr, 12, nullptr);
    EXPECT_TRUE(gst_rtsp_stream_transport_send_rtp(transport_.get(), packet));
    EXPECT_TRUE(gst_rtsp_stream_transport_send_rtcp(transport_.get(), packet));
    gst_buffer_unref(packet);
    EXPECT_EQ(sent_.rtp_lists, 1);
    EXPECT_EQ(sent_.rtcp_lists, 1);
    EXPECT_EQ(sent_.bytes, 12u);
    EXPECT_EQ(sent_.written, 0);  // told when it has been written
}

}  // namespace
}  // namespace camrig::rtsp
