#include "rtsp_out/rtsp/tcp_reader.h"

#include <vector>

#include <gst/app/gstappsink.h>
#include <gtest/gtest.h>

#include "rtsp_out/rtsp/gst_handle.h"

namespace camrig::rtsp {
namespace {

/// What a TCP reader is sent, and how many messages count as written.
struct Sent {
    std::vector<std::vector<guint8>> rtp;  ///< each packet's payload
    int rtp_lists = 0, rtcp_lists = 0, written = 0;
};

/// An RTP packet without extensions, or one of RTCP: `type` is its second byte (RFC 3550, 5.1 and 6.4).
GstBuffer* packet_of(guint8 type, const std::vector<guint8>& payload, GstClockTime picture = 1) {
    std::vector<guint8> bytes(12, 0);
    bytes[0] = 0x80;
    bytes[1] = type;
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    GstBuffer* packet = gst_buffer_new_memdup(bytes.data(), bytes.size());
    GST_BUFFER_PTS(packet) = picture * 40 * GST_MSECOND;
    return packet;
}
constexpr guint8 video = 96, last_of_picture = 0x80 | 96, sender_report = 200;
const std::vector<guint8> h264_parameters = {0x67, 1, 2}, h264_key = {0x65, 3}, h264_other = {0x41, 4};

/// The way to a reader: through an appsink's pad, as gst-rtsp-server takes from it and sends.
class TcpReader : public testing::Test {
protected:
    static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

    void SetUp() override {
        sink_.reset(GST_ELEMENT(gst_object_ref_sink(gst_element_factory_make("appsink", nullptr))));
        pad_.reset(gst_element_get_static_pad(sink_.get(), "sink"));
        g_object_set(sink_.get(), "sync", FALSE, "async", FALSE, nullptr);
        carry_packets(pad_.get(), [this] { return is_flushed_; });
        gst_element_set_state(sink_.get(), GST_STATE_PLAYING);
        gst_pad_send_event(pad_.get(), gst_event_new_stream_start("test"));
        GstSegment segment;
        gst_segment_init(&segment, GST_FORMAT_TIME);
        gst_pad_send_event(pad_.get(), gst_event_new_segment(&segment));
        join(NalCodec::h264);
    }
    void TearDown() override { gst_element_set_state(sink_.get(), GST_STATE_NULL); }

    void join(std::optional<NalCodec> codec) {
        payloader_.reset(GST_ELEMENT(gst_object_ref_sink(gst_element_factory_make("rtpjpegpay", nullptr))));
        const GObjectHandle<GstPad> pad(gst_element_get_static_pad(payloader_.get(), "src"));
        stream_.reset(gst_rtsp_stream_new(0, payloader_.get(), pad.get()));
        GstRTSPTransport* requested = nullptr;
        gst_rtsp_transport_new(&requested);
        transport_.reset(gst_rtsp_stream_transport_new(stream_.get(), requested));
        const auto take_rtp = +[](GstBufferList* packets, guint8, void* data) -> gboolean {
            auto& sent = *static_cast<Sent*>(data);
            ++sent.rtp_lists;
            for (guint i = 0; i < gst_buffer_list_length(packets); ++i) {
                GstBuffer* const packet = gst_buffer_list_get(packets, i);
                std::vector<guint8> payload(gst_buffer_get_size(packet) - 12);
                gst_buffer_extract(packet, 12, payload.data(), payload.size());
                sent.rtp.push_back(std::move(payload));
            }
            return TRUE;
        };
        const auto count_rtcp = +[](GstBufferList*, guint8, void* sent) -> gboolean {
            ++static_cast<Sent*>(sent)->rtcp_lists;
            return TRUE;
        };
        gst_rtsp_stream_transport_set_list_callbacks(transport_.get(), take_rtp, count_rtcp, &sent_, nullptr);
        gst_rtsp_stream_transport_set_message_sent_full(
            transport_.get(), +[](GstRTSPStreamTransport*, void* sent) { ++static_cast<Sent*>(sent)->written; }, &sent_,
            nullptr);
        unpack_carriers(transport_.get(), codec);
    }

    /// These packets come as a list, and go on as gst-rtsp-server sends what it takes from an appsink.
    void send(const std::vector<GstBuffer*>& packets, bool is_rtp = true) {
        GstBufferList* list = gst_buffer_list_new();
        for (GstBuffer* packet : packets) gst_buffer_list_add(list, packet);
        ASSERT_EQ(gst_pad_chain_list(pad_.get(), list), GST_FLOW_OK);
        pass_on(is_rtp);
    }
    void pass_on(bool is_rtp = true) {
        while (GstSample* sample = gst_app_sink_try_pull_sample(GST_APP_SINK(sink_.get()), 0)) {
            GstBuffer* const buffer = gst_sample_get_buffer(sample);
            ASSERT_NE(buffer, nullptr);
            EXPECT_EQ(gst_sample_get_buffer_list(sample), nullptr);
            EXPECT_TRUE(GST_BUFFER_PTS_IS_VALID(buffer));  // gst-rtsp-server aborts on none
            EXPECT_TRUE(is_rtp ? gst_rtsp_stream_transport_send_rtp(transport_.get(), buffer)
                               : gst_rtsp_stream_transport_send_rtcp(transport_.get(), buffer));
            gst_sample_unref(sample);
        }
    }

    bool is_flushed_ = false;
    GObjectHandle<GstElement> sink_;
    GObjectHandle<GstPad> pad_;
    GObjectHandle<GstElement> payloader_;
    GObjectHandle<GstRTSPStream> stream_;
    GObjectHandle<GstRTSPStreamTransport> transport_;
    Sent sent_;
};

TEST_F(TcpReader, PacketsArriveInTheListsTheyCameIn) {
    send({packet_of(video, h264_parameters), packet_of(last_of_picture, h264_key)});
    send({packet_of(last_of_picture, h264_other)});
    EXPECT_EQ(sent_.rtp, (std::vector{h264_parameters, h264_key, h264_other}));
    EXPECT_EQ(sent_.rtp_lists, 2);
    EXPECT_EQ(sent_.written, 0);  // told when they have been written
}

TEST_F(TcpReader, ASinglePacketIsAListOfOne) {
    ASSERT_EQ(gst_pad_chain(pad_.get(), packet_of(video, h264_parameters)), GST_FLOW_OK);
    pass_on();
    send({packet_of(sender_report, {})}, false);
    EXPECT_EQ(sent_.rtp_lists, 1);
    EXPECT_EQ(sent_.rtcp_lists, 1);
}

TEST_F(TcpReader, AfterPacketsOfAPictureABufferOfNoBytesComesAndReachesNobody) {
    is_flushed_ = true;
    send({packet_of(video, h264_parameters), packet_of(last_of_picture, h264_key)});
    EXPECT_EQ(sent_.written, 1);  // nothing between them
    send({packet_of(video, h264_other)});
    EXPECT_EQ(sent_.written, 2);  // a fault may have taken the picture's last packet
    send({packet_of(sender_report, {})}, false);
    EXPECT_EQ(sent_.written, 2);
    EXPECT_EQ(sent_.rtp_lists, 2);
    is_flushed_ = false;
    send({packet_of(last_of_picture, h264_other)});
    EXPECT_EQ(sent_.written, 2);
}

TEST_F(TcpReader, TheFirstThatANewReaderGetsIsAKeyPicture) {
    send({packet_of(video, h264_other, 1)});
    send({packet_of(video, h264_parameters, 1)});  // in the middle of a picture
    send({packet_of(last_of_picture, h264_key, 1)});
    send({packet_of(last_of_picture, h264_other, 2)});
    send({packet_of(sender_report, {}, 2)}, false);
    EXPECT_TRUE(sent_.rtp.empty());
    EXPECT_EQ(sent_.written, 4);  // what is left out does not hold up what comes behind it
    EXPECT_EQ(sent_.rtcp_lists, 1);
    send({packet_of(video, h264_parameters, 3)});
    send({packet_of(last_of_picture, h264_key, 3)});
    send({packet_of(last_of_picture, h264_other, 4)});
    EXPECT_EQ(sent_.rtp, (std::vector{h264_parameters, h264_key, h264_other}));
}

TEST_F(TcpReader, ParameterSetsAreFoundInAggregationPackets) {
    send({packet_of(video, {24, 0, 2, 0x41, 4}, 1)});
    EXPECT_TRUE(sent_.rtp.empty());
    send({packet_of(video, {24, 0, 2, 9, 0x10, 0, 2, 0x67, 1}, 2)});  // behind a delimiter
    EXPECT_EQ(sent_.rtp.size(), 1u);
}

TEST_F(TcpReader, H265BeginsWithItsVideoParameterSet) {
    join(NalCodec::h265);
    send({packet_of(video, {0x02, 1, 9}, 1)});              // a slice
    send({packet_of(video, {0x60, 1, 0, 2, 0x02, 1}, 2)});  // an aggregation of slices
    EXPECT_TRUE(sent_.rtp.empty());
    send({packet_of(video, {0x60, 1, 0, 2, 0x40, 1}, 3)});
    send({packet_of(video, {0x02, 1, 9}, 3)});
    EXPECT_EQ(sent_.rtp.size(), 2u);
    sent_ = {};
    join(NalCodec::h265);
    send({packet_of(video, {0x40, 1, 9}, 4)});
    EXPECT_EQ(sent_.rtp.size(), 1u);
}

TEST_F(TcpReader, EveryPictureOfJpegIsAKeyPicture) {
    join(std::nullopt);
    send({packet_of(video, {0, 0, 0, 0})});
    EXPECT_EQ(sent_.rtp.size(), 1u);
}

TEST_F(TcpReader, PacketsCutShortAreNoKeyPicture) {
    const std::vector<std::vector<guint8>> cut = {{}, {24}, {24, 0, 9}, {24, 0, 9, 9, 0x67}, {24, 0, 0, 0, 0}};
    for (std::size_t i = 0; i < cut.size(); ++i) send({packet_of(video, cut[i], i)});
    EXPECT_TRUE(sent_.rtp.empty());
}

}  // namespace
}  // namespace camrig::rtsp
