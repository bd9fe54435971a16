#include <map>
#include <set>

#include <gtest/gtest.h>

#include "server_fixture.h"
#include "tests/unit/fault/faulty.h"

namespace camrig::http {
namespace {

class LiveStreamTest : public ServerTest {
protected:
    LiveStreamTest() {
        fetcher.make = [](const stream::FetchRequest& request) { return jpeg_unit(request.camera, 0); };
    }
    TestClient::Reply open(TestClient& client, std::string_view query = "cameras=lobby,hall") {
        client.get("/live?" + std::string(query));
        return client.read_head();
    }
};

TEST_F(LiveStreamTest, PartsSayWhosePictureTheyAre) {
    start();
    TestClient client(server->port());
    EXPECT_EQ(open(client).fields.at("Content-Type"), "multipart/mixed; boundary=frame");
    std::multiset<std::string> first{client.read_part().fields.at("X-Camera"),
                                     client.read_part().fields.at("X-Camera")};
    EXPECT_EQ(first, (std::multiset<std::string>{"hall", "lobby"}));
    for (const char* name : {"hall", "lobby", "hall"}) {
        bus.publish(jpeg_unit(name, 1 + static_cast<int>(bus.last_stats->offered), 500));
        const auto part = client.read_part();
        EXPECT_EQ(part.fields.at("X-Camera"), name);
        EXPECT_EQ(part.body.size(), 500U);
    }
}

TEST_F(LiveStreamTest, PicturesAreScaledInTheirOwnProportionsAndNeverEnlarged) {
    bus.known = {{CameraId{1}, "lobby", {1920, 1080}, {}}, {CameraId{2}, "hall", {128, 96}, {}}};
    start();
    TestClient client(server->port());
    open(client, "cameras=lobby,hall&width=320&fps=15&quality=70");
    EXPECT_EQ(bus.reader(0)->format.size, (ImageSize{320, 180}));
    EXPECT_EQ(bus.reader(0)->format.quality, 70);
    EXPECT_EQ(*bus.reader(0)->options.rate, *Rate::create(15, 1));
    EXPECT_EQ(bus.reader(1)->format.size, ImageSize{});
    EXPECT_EQ(fetcher.requests.at(0).format.size, (ImageSize{320, 180}));
}

TEST_F(LiveStreamTest, ASlowClientSeesEveryCamerasNewestPicture) {
    start();
    TestClient client(server->port(), 4096);
    open(client);
    client.read_part();
    client.read_part();
    constexpr int frames = 60;
    for (int sequence = 1; sequence <= frames; ++sequence)
        for (const char* name : {"lobby", "hall"}) bus.publish(jpeg_unit(name, sequence, 1 << 20));
    std::map<std::string, std::string> last;
    int parts = 0;
    while (last["lobby"] != std::to_string(frames) || last["hall"] != std::to_string(frames)) {
        const auto part = client.read_part();
        last[part.fields.at("X-Camera")] = part.fields.at("X-Sequence");
        ++parts;
    }
    EXPECT_LT(parts, frames);
}

TEST_F(LiveStreamTest, WhenOneOfItsCamerasGoesTheStreamEnds) {
    start();
    TestClient client(server->port());
    open(client);
    client.read_part();
    client.read_part();
    bus.end("hall");
    EXPECT_TRUE(client.read_to_end().ends_with("--frame--\r\n"));
    EXPECT_TRUE(eventually([&] { return bus.reader_count() == 0; }));
    EXPECT_EQ(server->counts().streams_open, 0U);
}

TEST_F(LiveStreamTest, AFaultThatCutsOneCamerasPartsLeavesTheStreamWhole) {
    start();
    TestClient client(server->port());
    open(client);
    client.read_part();
    client.read_part();
    stream::MediaUnit cut = jpeg_unit("hall", 1);
    cut.info.faults = std::make_shared<const fault::FrameFaults>(
        fault::at_frame(fault::fault_of(fault::CutPart{.probability = 1}), 1));
    bus.publish(cut);
    EXPECT_EQ(client.read_part().body.size(), 100U);
    bus.publish(jpeg_unit("lobby", 1));
    EXPECT_EQ(client.read_part().fields.at("X-Camera"), "lobby");
}

TEST_F(LiveStreamTest, WhatACameraThatFailsThrowsOutComesBackAndTheOthersGoOn) {
    options.limits.reopen_after = std::chrono::milliseconds(20);
    start();
    TestClient client(server->port());
    open(client);
    client.read_part();
    client.read_part();
    bus.throw_out("hall");
    bus.publish(jpeg_unit("lobby", 1));
    EXPECT_EQ(client.read_part().fields.at("X-Camera"), "lobby");
    EXPECT_TRUE(eventually([&] { return bus.reader_count() == 2; }));
    bus.publish(jpeg_unit("hall", 2));
    EXPECT_EQ(client.read_part().fields.at("X-Camera"), "hall");
    EXPECT_EQ(fetcher.request_count(), 2U) << "what it shows is the newest there is";
}

TEST_F(LiveStreamTest, ACameraThatRefusesIsLeftOutUntilItLetsReadersIn) {
    options.limits.reopen_after = std::chrono::milliseconds(20);
    options.limits.repeat_after = std::chrono::milliseconds(20);
    bus.known.front().standing.refused = 1U << static_cast<unsigned>(fault::Output::mjpeg);
    start();
    TestClient client(server->port());
    EXPECT_EQ(open(client).status, 200);
    EXPECT_EQ(client.read_part().fields.at("X-Camera"), "hall");
    for (int signs = 0; signs < 3; ++signs) EXPECT_FALSE(client.read_part().fields.contains("X-Camera"));
    EXPECT_EQ(bus.reader_count(), 1U);
    EXPECT_EQ(bus.refused, 1);
    bus.let_in();
    TestClient::Reply part = client.read_part();
    while (!part.fields.contains("X-Camera")) part = client.read_part();
    EXPECT_EQ(part.fields.at("X-Camera"), "lobby");
    EXPECT_EQ(bus.reader_count(), 2U);
}

TEST_F(LiveStreamTest, AnUnknownCameraIsAnErrorAndLeavesNoReader) {
    start();
    TestClient client(server->port());
    EXPECT_EQ(open(client, "cameras=lobby,nobody").status, 404);
    EXPECT_EQ(bus.reader_count(), 0U);
    EXPECT_EQ(server->counts().streams_open, 0U);
}

TEST_F(LiveStreamTest, AClientThatLeavesIsNoticedAndASilentStreamShowsLife) {
    options.limits.repeat_after = std::chrono::milliseconds(20);
    start();
    auto client = std::make_unique<TestClient>(server->port());
    open(*client);
    client->read_part();
    client->read_part();
    const auto part = client->read_part();
    EXPECT_FALSE(part.fields.contains("X-Camera"));
    EXPECT_TRUE(part.body.empty());
    client.reset();
    EXPECT_TRUE(eventually([&] { return bus.reader_count() == 0; }));
}

TEST_F(LiveStreamTest, WidthsCountAgainstTheEncodingsOfACamera) {
    options.limits.qualities_per_camera = 2;
    bus.known = {{CameraId{1}, "lobby", {1920, 1080}, {}}};
    start();
    TestClient one(server->port()), two(server->port()), three(server->port()), four(server->port());
    EXPECT_EQ(open(one, "cameras=lobby&width=320").status, 200);
    EXPECT_EQ(open(two, "cameras=lobby&width=640").status, 200);
    EXPECT_EQ(open(three, "cameras=lobby").status, 503);
    EXPECT_EQ(open(four, "cameras=lobby&width=320").status, 200);
}

}  // namespace
}  // namespace camrig::http
