#include <set>

#include <gtest/gtest.h>

#include "server_fixture.h"

namespace camrig::http {
namespace {

class MjpegStreamTest : public ServerTest {
protected:
    MjpegStreamTest() {
        fetcher.make = [](const stream::FetchRequest& request) { return jpeg_unit(request.camera, 0); };
    }
    /// Opens a stream and reads its head.
    TestClient::Reply open(TestClient& client, std::string_view query = {}) {
        client.get("/cameras/lobby/stream.mjpg" + std::string(query));
        return client.read_head();
    }
    static std::string sequence_of(const TestClient::Reply& part) {
        return part.fields.contains("X-Sequence") ? part.fields.at("X-Sequence") : "none";
    }
    bool books_balance() const {
        const auto& stats = *bus.last_stats;
        return stats.offered == stats.delivered + stats.dropped;
    }
};

TEST_F(MjpegStreamTest, TheBytesAreExactlyWhatStockReadersTake) {
    start();
    TestClient client(server->port());
    const auto head = open(client);
    EXPECT_EQ(head.status, 200);
    EXPECT_EQ(head.fields.at("Content-Type"), "multipart/x-mixed-replace; boundary=frame");
    EXPECT_EQ(head.fields.at("Connection"), "close");
    EXPECT_EQ(head.fields.at("Cache-Control"), "no-store");
    EXPECT_FALSE(head.fields.contains("Transfer-Encoding"));
    EXPECT_FALSE(head.fields.contains("Content-Length"));

    const stream::MediaUnit first = *fetcher.make({.camera = "lobby", .kind = {}, .min_ns = 0, .format = {}});
    EXPECT_EQ(client.read_line(), "--frame");
    EXPECT_EQ(client.read_line(), "Content-Type: image/jpeg");
    EXPECT_EQ(client.read_line(), "Content-Length: 100");
    EXPECT_EQ(client.read_line(), "X-Sequence: 0");
    EXPECT_EQ(client.read_line(), "X-World-Time-Ns: 0");
    EXPECT_TRUE(client.read_line().starts_with("X-Monotonic-Ns: "));
    EXPECT_EQ(client.read_line(), "");
    EXPECT_EQ(client.read_exactly(100), std::string(reinterpret_cast<const char*>(first.bytes->data()), 100));
    // Nothing more is published: the next boundary line must be here already (Chrome waits for it).
    EXPECT_EQ(client.read_exactly(11), "\r\n--frame\r\n");
}

TEST_F(MjpegStreamTest, PartsFollowThePublishedFrames) {
    start();
    TestClient client(server->port());
    open(client, "?fps=30000/1001&quality=55");
    EXPECT_EQ(sequence_of(client.read_part()), "0");
    for (int sequence = 1; sequence < 20; ++sequence) {
        bus.publish(jpeg_unit("lobby", sequence, 1000));
        const auto part = client.read_part();
        EXPECT_EQ(sequence_of(part), std::to_string(sequence));
        EXPECT_EQ(part.fields.at("X-World-Time-Ns"), std::to_string(sequence * 40'000'000));
        EXPECT_EQ(part.body.size(), 1000U);
    }
    const auto reader = bus.reader();
    EXPECT_EQ(*reader->options.rate, *Rate::create(30000, 1001));
    EXPECT_EQ(reader->options.kind, "mjpeg");
    EXPECT_TRUE(reader->options.peer.starts_with("127.0.0.1:"));
    EXPECT_EQ(reader->format.codec, codec::Codec::jpeg);
    EXPECT_EQ(reader->format.quality, 55);
    EXPECT_TRUE(eventually([&] { return reader->stats->delivered == 19 && books_balance(); }));
    EXPECT_EQ(reader->stats->bytes, 19'000U);
    EXPECT_GT(reader->stats->last_latency_ns, 0);
    EXPECT_EQ(server->counts().first_parts, 1U);
}

TEST_F(MjpegStreamTest, TheCamerasOutputSaysTheQuality) {
    bus.known.front().outputs = {{.kind = "mjpeg", .options = {{"quality", 70}}}};
    start();
    TestClient plain(server->port());
    open(plain);
    plain.read_part();
    EXPECT_EQ(bus.reader()->format.quality, 70);
}

TEST_F(MjpegStreamTest, AReaderMayAskForAnotherQualityThanTheCamerasOutputSays) {
    bus.known.front().outputs = {{.kind = "mjpeg", .options = {{"quality", 70}}}};
    start();
    TestClient asking(server->port());
    open(asking, "?quality=55");
    asking.read_part();
    EXPECT_EQ(bus.reader()->format.quality, 55);
}

TEST_F(MjpegStreamTest, AnOpenStreamFollowsTheCamerasOutputUnlessItsReaderAskedForAQuality) {
    start();
    TestClient plain(server->port()), asking(server->port());
    open(plain);
    plain.read_part();
    open(asking, "?quality=55");
    asking.read_part();
    const auto qualities = [&] { return std::multiset{bus.reader(0)->format.quality, bus.reader(1)->format.quality}; };
    bus.change({{.kind = "mjpeg", .options = {{"quality", 30}}}});
    ASSERT_TRUE(eventually([&] { return bus.reader_count() == 2 && qualities() == std::multiset{30, 55}; }));
    plain.read_part();  // what it shows already, in the other quality
    bus.publish(jpeg_unit("lobby", 20, 1000));
    for (TestClient* client : {&plain, &asking}) EXPECT_EQ(sequence_of(client->read_part()), "20");
}

// A world that stands still brings no picture, and it is long until the last would be repeated.
TEST_F(MjpegStreamTest, AnIdleStreamShowsAnotherQualityAtOnce) {
    options.limits.repeat_after = std::chrono::minutes(10);
    fetcher.make = [](const stream::FetchRequest& request) {
        return jpeg_unit(request.camera, 7, static_cast<std::size_t>(request.format.quality));
    };
    start();
    TestClient client(server->port());
    open(client);
    EXPECT_EQ(client.read_part().body.size(), 90U);
    bus.change({{.kind = "mjpeg", .options = {{"quality", 30}}}});
    EXPECT_EQ(client.read_part().body.size(), 30U);
}

TEST_F(MjpegStreamTest, TheFetchedPictureIsNotSentAgainWhenTheBusBringsItToo) {
    fetcher.make = nullptr;
    start();
    TestClient client(server->port());
    open(client);
    ASSERT_TRUE(eventually([&] { return fetcher.request_count() == 1; }));
    fetcher.answer(jpeg_unit("lobby", 7));
    EXPECT_EQ(sequence_of(client.read_part()), "7");
    const auto latch = stream::DeliveryLatch::create();
    stream::MediaUnit same = jpeg_unit("lobby", 7);
    same.latch = latch;
    bus.publish(same);
    ASSERT_TRUE(eventually([&] { return latch->holders().empty(); }));
    bus.publish(jpeg_unit("lobby", 8));
    EXPECT_EQ(sequence_of(client.read_part()), "8");
    EXPECT_TRUE(eventually([&] { return bus.last_stats->delivered == 2 && books_balance(); }));
}

TEST_F(MjpegStreamTest, AFetchThatComesLateIsForgotten) {
    fetcher.make = nullptr;
    start();
    TestClient client(server->port());
    open(client);
    ASSERT_TRUE(eventually([&] { return fetcher.request_count() == 1; }));
    bus.publish(jpeg_unit("lobby", 3));
    EXPECT_EQ(sequence_of(client.read_part()), "3");
    fetcher.answer(jpeg_unit("lobby", 2));
    bus.publish(jpeg_unit("lobby", 4));
    EXPECT_EQ(sequence_of(client.read_part()), "4");
}

TEST_F(MjpegStreamTest, WithoutNewFramesTheLastPictureIsRepeatedAndCountedApart) {
    options.limits.repeat_after = std::chrono::milliseconds(20);
    start();
    TestClient client(server->port());
    open(client);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(sequence_of(client.read_part()), "0");
    EXPECT_GE(server->counts().repeated_parts, 3U);
    EXPECT_EQ(bus.last_stats->offered, 0U);
    EXPECT_EQ(bus.last_stats->delivered, 0U);
}

TEST_F(MjpegStreamTest, AFirstPictureThatFailedIsAskedForAgain) {
    options.limits.repeat_after = std::chrono::milliseconds(20);
    fetcher.make = nullptr;
    start();
    TestClient client(server->port());
    open(client);
    ASSERT_TRUE(eventually([&] { return fetcher.request_count() == 1; }));
    fetcher.answer(error(ErrorKind::unavailable, "not yet"));
    ASSERT_TRUE(eventually([&] { return fetcher.request_count() == 2; }));
    fetcher.answer(jpeg_unit("lobby", 1));
    EXPECT_EQ(sequence_of(client.read_part()), "1");
}

TEST_F(MjpegStreamTest, ASlowClientGetsTheNewestFrameAndTheBooksBalance) {
    start();
    TestClient client(server->port(), 4096);
    open(client);
    client.read_part();
    constexpr std::int64_t frames = 100;
    constexpr std::size_t size = 1 << 20;
    // Far more than the kernel's buffers hold, while the client reads nothing.
    for (std::int64_t sequence = 1; sequence <= frames; ++sequence) bus.publish(jpeg_unit("lobby", sequence, size));
    std::int64_t last = 0;
    int parts = 0;
    while (last < frames) {
        const auto part = client.read_part();
        ASSERT_EQ(part.body.size(), size);
        const std::int64_t sequence = std::stoll(sequence_of(part));
        EXPECT_GT(sequence, last);
        last = sequence;
        ++parts;
    }
    EXPECT_LT(parts, 20);
    EXPECT_TRUE(eventually([&] { return books_balance(); }));
    EXPECT_EQ(bus.last_stats->delivered, static_cast<std::uint64_t>(parts));
    EXPECT_EQ(bus.last_stats->offered, static_cast<std::uint64_t>(frames));
}

TEST_F(MjpegStreamTest, InLockstepTheLatchOpensOnlyWhenTheBytesAreWithTheKernel) {
    start();
    TestClient client(server->port(), 4096);
    open(client);
    client.read_part();
    const auto latch = stream::DeliveryLatch::create();
    stream::MediaUnit unit = jpeg_unit("lobby", 1, 32 << 20);  // more than any socket buffer takes
    unit.latch = latch;
    bus.publish(unit);
    const auto holders = latch->holders();
    ASSERT_EQ(holders.size(), 1U);
    EXPECT_TRUE(holders.front().starts_with("MJPEG reader 127.0.0.1:"));
    EXPECT_TRUE(holders.front().ends_with(" of camera lobby"));
    EXPECT_EQ(client.read_part().body.size(), 32U << 20);
    EXPECT_TRUE(eventually([&] { return latch->holders().empty(); }));
}

TEST_F(MjpegStreamTest, AClientThatVanishesFreesEverything) {
    start();
    auto client = std::make_unique<TestClient>(server->port(), 4096);
    open(*client);
    client->read_part();
    ASSERT_EQ(bus.reader_count(), 1U);
    const auto latch = stream::DeliveryLatch::create();
    std::weak_ptr<const std::vector<std::byte>> bytes;
    for (int sequence = 1; sequence < 4; ++sequence) {
        stream::MediaUnit unit = jpeg_unit("lobby", sequence, 32 << 20);
        unit.latch = latch;
        bytes = unit.bytes;
        bus.publish(unit);
    }
    client.reset();  // in the middle of a picture
    EXPECT_TRUE(eventually([&] { return bus.reader_count() == 0; }));
    EXPECT_TRUE(eventually([&] { return bus.last_sink.expired() && bytes.expired(); }));
    EXPECT_TRUE(latch->holders().empty());
    EXPECT_TRUE(books_balance());
    EXPECT_TRUE(eventually([&] { return server->counts().connections.open == 0; }));
    EXPECT_EQ(server->counts().streams_open, 0U);
}

TEST_F(MjpegStreamTest, AClientThatLeavesWhileNothingHappensIsNoticed) {
    start();
    auto client = std::make_unique<TestClient>(server->port());
    open(*client);
    client->read_part();
    client.reset();
    EXPECT_TRUE(eventually([&] { return bus.reader_count() == 0 && bus.last_sink.expired(); }));
}

TEST_F(MjpegStreamTest, AClientThatTakesNothingIsClosedAfterTheTimeLimit) {
    options.limits.stalled_after = std::chrono::milliseconds(50);
    start();
    TestClient client(server->port(), 4096);
    open(client);
    client.read_part();
    bus.publish(jpeg_unit("lobby", 1, 32 << 20));
    EXPECT_TRUE(eventually([&] { return bus.reader_count() == 0; }));
    EXPECT_EQ(server->counts().stalled, 1U);
    EXPECT_TRUE(books_balance());
}

TEST_F(MjpegStreamTest, WhenTheCameraGoesTheStreamEndsAndAClientCanComeBack) {
    start();
    TestClient client(server->port());
    open(client);
    client.read_part();
    bus.publish(jpeg_unit("lobby", 1));
    bus.throw_out("lobby");
    EXPECT_EQ(sequence_of(client.read_part()), "1");
    EXPECT_TRUE(client.read_to_end().ends_with("--frame--\r\n"));
    TestClient again(server->port());
    open(again);
    EXPECT_EQ(sequence_of(again.read_part()), "0");
}

TEST_F(MjpegStreamTest, QualitiesPerCameraAreBoundedButThoseInUseAreShared) {
    options.limits.qualities_per_camera = 2;
    start();
    TestClient one(server->port()), two(server->port()), three(server->port()), four(server->port());
    EXPECT_EQ(open(one, "?quality=10").status, 200);
    EXPECT_EQ(open(two, "?quality=20").status, 200);
    EXPECT_EQ(open(three, "?quality=30").status, 503);
    EXPECT_EQ(open(four, "?quality=20").status, 200);
    one.close();
    ASSERT_TRUE(eventually([&] { return bus.reader_count() == 2; }));
    TestClient five(server->port());
    EXPECT_EQ(open(five, "?quality=30").status, 200);
}

TEST_F(MjpegStreamTest, StoppingTheServerEndsStreamsAndFetches) {
    fetcher.make = nullptr;
    start();
    TestClient stream(server->port()), snapshot(server->port());
    open(stream);
    snapshot.get("/cameras/lobby/snapshot.jpg");
    ASSERT_TRUE(eventually([&] { return fetcher.request_count() == 2; }));
    server.reset();
    EXPECT_EQ(bus.reader_count(), 0U);
    // Answers that come after the server is gone go nowhere.
    fetcher.answer(jpeg_unit("lobby", 1));
    fetcher.answer(jpeg_unit("lobby", 1));
    stream.read_to_end();
    EXPECT_TRUE(stream.at_end());
}

}  // namespace
}  // namespace camrig::http
