#include "rtsp_out/http/mjpeg_sink.h"

#include <boost/asio/io_context.hpp>
#include <gtest/gtest.h>

namespace camrig::http {
namespace {

class MjpegSinkTest : public testing::Test {
protected:
    MjpegSinkTest() {
        stream::StreamInfo info;
        info.stats = stats;
        EXPECT_TRUE(sink.open(info));
    }
    stream::MediaUnit unit(std::int64_t sequence) {
        stream::MediaUnit made;
        made.info.sequence = sequence;
        made.bytes = std::make_shared<const std::vector<std::byte>>(10);
        made.latch = latch;
        return made;
    }

    boost::asio::io_context io;
    AsyncEventRef event = std::make_shared<AsyncEvent>(io.get_executor());
    std::shared_ptr<stream::ReaderStats> stats = std::make_shared<stream::ReaderStats>();
    std::shared_ptr<stream::DeliveryLatch> latch = stream::DeliveryLatch::create();
    MjpegSink sink{event, "lobby", "127.0.0.1:5123"};
};

TEST_F(MjpegSinkTest, TheNewestUnitReplacesTheWaitingOneAndTheBooksSaySo) {
    for (int sequence = 0; sequence < 5; ++sequence) ASSERT_TRUE(sink.write(unit(sequence)));
    auto item = sink.take();
    ASSERT_TRUE(item);
    EXPECT_EQ(item->unit.info.sequence, 4);
    EXPECT_FALSE(sink.take());
    sink.sent(std::move(*item), 10);
    EXPECT_EQ(stats->dropped, 4U);
    EXPECT_EQ(stats->delivered, 1U);
    EXPECT_EQ(stats->bytes, 10U);
}

TEST_F(MjpegSinkTest, TheLatchIsHeldByNameUntilTheBytesAreSent) {
    ASSERT_TRUE(sink.write(unit(0)));
    ASSERT_EQ(latch->holders().size(), 1U);
    EXPECT_EQ(latch->holders().front(), "MJPEG reader 127.0.0.1:5123 of camera lobby");
    auto item = sink.take();
    EXPECT_EQ(latch->holders().size(), 1U);
    sink.sent(std::move(*item), 10);
    EXPECT_TRUE(latch->holders().empty());
}

TEST_F(MjpegSinkTest, ReplacedDroppedAndAbandonedUnitsLetTheLatchGo) {
    ASSERT_TRUE(sink.write(unit(0)));
    ASSERT_TRUE(sink.write(unit(1)));
    EXPECT_EQ(latch->holders().size(), 1U);
    sink.dropped(std::move(*sink.take()));
    EXPECT_TRUE(latch->holders().empty());
    ASSERT_TRUE(sink.write(unit(2)));
    sink.abandon();
    EXPECT_TRUE(latch->holders().empty());
    ASSERT_TRUE(sink.write(unit(3)));
    EXPECT_TRUE(latch->holders().empty());
    EXPECT_EQ(stats->dropped, 4U);
}

TEST_F(MjpegSinkTest, AUnitThatWaitsWhenTheCameraGoesMayStillBeSent) {
    ASSERT_TRUE(sink.write(unit(0)));
    sink.close();
    sink.close();
    EXPECT_TRUE(sink.ended());
    auto item = sink.take();
    ASSERT_TRUE(item);
    sink.sent(std::move(*item), 10);
    EXPECT_EQ(stats->delivered, 1U);
}

TEST_F(MjpegSinkTest, BellsMayRingAfterTheirServerIsGone) {
    event->disconnect();
    io.stop();
    EXPECT_TRUE(sink.write(unit(0)));
    sink.close();
}

}  // namespace
}  // namespace camrig::http
