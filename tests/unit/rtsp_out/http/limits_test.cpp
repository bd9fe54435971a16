
#include <stdexcept>

#include <gtest/gtest.h>

#include "server_fixture.h"

namespace camrig::http {
namespace {

using Limits = ServerTest;

TEST_F(Limits, AHostThatOthersCanReachNeedsAToken) {
    options.host = "0.0.0.0";
    const auto refused = HttpServer::create(options);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::invalid_argument);
    EXPECT_NE(refused.error().message.find("--token-file"), std::string::npos);
    options.token = "bad token";
    EXPECT_FALSE(HttpServer::create(options));
    options.token = "long-enough-token";
    EXPECT_TRUE(HttpServer::create(options));
}

TEST_F(Limits, APortInUseIsAnErrorThatSaysSo) {
    start();
    options.port = server->port();
    const auto second = HttpServer::create(options);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().kind, ErrorKind::unavailable);
    EXPECT_NE(second.error().message.find(std::to_string(options.port)), std::string::npos);
}

TEST_F(Limits, LargeBodiesAreRefusedBeforeAndWhileTheyCome) {
    options.hooks.rpc = [](const std::string&, bool, const auto& reply) { reply(RpcText{{"{}"}}); };
    start();
    EXPECT_EQ(post_rpc(std::string(1024 * 1024, ' ')).status, 200);
    const std::string head = "POST /rpc HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n";
    TestClient declared(server->port());
    declared.send(head + "Content-Length: 104857600\r\n\r\n");
    EXPECT_EQ(declared.read_reply().status, 413);
    TestClient chunked(server->port());
    chunked.send(head + "Transfer-Encoding: chunked\r\n\r\n");
    for (int i = 0; i < 20; ++i) chunked.send("10000\r\n" + std::string(65536, ' ') + "\r\n");
    EXPECT_EQ(chunked.read_reply().status, 413);
}

TEST_F(Limits, ExpectContinueIsAnswered) {
    options.hooks.rpc = [](const std::string& body, bool, const auto& reply) { reply(RpcText{{body}}); };
    start();
    TestClient client(server->port());
    client.send(
        "POST /rpc HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 2\r\n"
        "Expect: 100-continue\r\n\r\n");
    EXPECT_EQ(client.read_until("\r\n\r\n"), "HTTP/1.1 100 Continue\r\n\r\n");
    client.send("{}");
    EXPECT_EQ(client.read_reply().body, "{}");
}

TEST_F(Limits, LongRequestLinesAndHeadersAreRefused) {
    start();
    EXPECT_EQ(get("/" + std::string(3000, 'a')).status, 414);
    EXPECT_EQ(get("/" + std::string(100'000, 'a')).status, 414);
    EXPECT_EQ(get("/healthz", "X: " + std::string(100'000, 'a') + "\r\n").status, 431);
    std::string many;
    for (int i = 0; i < 2000; ++i) many += "X-" + std::to_string(i) + ": 1\r\n";
    EXPECT_EQ(get("/healthz", many).status, 431);
}

TEST_F(Limits, WhatIsNotHttpGetsA400) {
    start();
    for (const std::string text :
         {"\x16\x03\x01 TLS hello\r\n\r\n", "GET\r\n\r\n", "GET / HTTP/9.9\r\n\r\n", "GET /a b HTTP/1.1\r\n\r\n",
          "GET / HTTP/1.1\r\nno colon\r\n\r\n", "POST /rpc HTTP/1.1\r\nHost: localhost\r\nContent-Length: x\r\n\r\n"}) {
        TestClient client(server->port());
        client.send(text);
        const auto reply = client.read_reply();
        EXPECT_EQ(reply.status, 400) << text;
        EXPECT_TRUE(client.at_end()) << text;
    }
}

TEST_F(Limits, ConnectionsOverTheLimitAreToldWhenAllAreInUseAndOthersLiveOn) {
    options.limits.connections = 2;
    start();
    TestClient one(server->port()), two(server->port());
    for (TestClient* reader : {&one, &two}) {
        reader->get("/cameras/lobby/stream.mjpg");
        EXPECT_EQ(reader->read_head().status, 200);
    }
    ASSERT_TRUE(eventually([&] { return bus.reader_count() == 2; }));
    TestClient three(server->port());
    EXPECT_EQ(three.read_reply().status, 503);
    EXPECT_EQ(server->counts().connections.refused, 1U);
    bus.publish(jpeg_unit("lobby", 1));
    EXPECT_EQ(two.read_part().fields["X-Sequence"], "1");
    one.close();
    ASSERT_TRUE(eventually([&] { return server->counts().connections.open == 1; }));
    EXPECT_EQ(get("/healthz").status, 200);
}

TEST_F(Limits, SlowAndSilentOnesMakeRoomForWhoAsks) {
    options.limits.connections = 3;
    start();
    TestClient reader(server->port());
    reader.get("/cameras/lobby/stream.mjpg");
    EXPECT_EQ(reader.read_head().status, 200);
    TestClient silent(server->port());
    ASSERT_TRUE(eventually([&] { return server->counts().connections.open == 2; }));
    TestClient slow(server->port());
    slow.send("GET /healthz HTTP/1.1\r\nHost: loc");
    ASSERT_TRUE(eventually([&] { return server->counts().connections.open == 3; }));
    TestClient asks(server->port());
    asks.get("/healthz");
    EXPECT_EQ(asks.read_reply().status, 200);
    EXPECT_TRUE(silent.at_end());  // it had waited longest
    slow.send("alhost\r\n\r\n");
    EXPECT_EQ(slow.read_reply().status, 200);
    bus.publish(jpeg_unit("lobby", 1));
    EXPECT_EQ(reader.read_part().fields["X-Sequence"], "1");
    EXPECT_EQ(server->counts().connections.displaced, 1U);
    EXPECT_EQ(server->counts().connections.refused, 0U);
}

TEST_F(Limits, ThoseThatHaveNotAskedHaveFewPlaces) {
    options.limits.waiting_connections = 2;
    start();
    TestClient first(server->port()), second(server->port()), third(server->port());
    EXPECT_TRUE(first.at_end());
    second.get("/healthz");
    EXPECT_EQ(second.read_reply().status, 200);
    EXPECT_EQ(server->counts().connections.displaced, 1U);
}

TEST_F(Limits, ConnectionsOfOnePeerAreBounded) {
    options.limits.connections_per_local_peer = 1;
    start();
    TestClient first(server->port());
    first.get("/cameras/lobby/stream.mjpg");
    EXPECT_EQ(first.read_head().status, 200);
    ASSERT_TRUE(eventually([&] { return bus.reader_count() == 1; }));
    TestClient second(server->port());
    EXPECT_EQ(second.read_reply().status, 503);
    bus.publish(jpeg_unit("lobby", 1));
    EXPECT_EQ(first.read_part().fields["X-Sequence"], "1");
}

TEST_F(Limits, AWaitingConnectionOfAPeerMakesRoomForItsNext) {
    options.limits.connections_per_local_peer = 2;
    start();
    TestClient reader(server->port());
    reader.get("/cameras/lobby/stream.mjpg");
    EXPECT_EQ(reader.read_head().status, 200);
    TestClient idle(server->port());
    ASSERT_TRUE(eventually([&] { return server->counts().connections.open == 2; }));
    TestClient next(server->port());
    next.get("/healthz");
    EXPECT_EQ(next.read_reply().status, 200);
    EXPECT_TRUE(idle.at_end());
    EXPECT_EQ(server->counts().connections.displaced, 1U);
    EXPECT_EQ(server->counts().connections.refused, 0U);
    bus.publish(jpeg_unit("lobby", 1));
    EXPECT_EQ(reader.read_part().fields["X-Sequence"], "1");
}

TEST_F(Limits, PicturesUnderWayAreBoundedBeforeTheyAreDrawn) {
    options.limits.picture_bytes = 64 * 48 * 4;
    int drawn = 0;
    fetcher.make = [&drawn](const stream::FetchRequest& request) -> Result<stream::MediaUnit> {
        const ImageSize size = request.camera == "hall" ? ImageSize{64, 49} : ImageSize{64, 48};
        if (auto admitted = request.admit(size); !admitted) return std::unexpected(admitted.error());
        ++drawn;
        return jpeg_unit(request.camera, 1);
    };
    start();
    EXPECT_EQ(get("/cameras/hall/snapshot.jpg").status, 503);
    EXPECT_EQ(drawn, 0);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(get("/cameras/lobby/snapshot.jpg").status, 200);
    EXPECT_EQ(drawn, 3);
}

TEST_F(Limits, AWrongTokenIsHeldBackAndCounted) {
    options.token = "correct-token";
    options.limits.wrong_token = std::chrono::milliseconds(1);
    start();
    EXPECT_EQ(get("/healthz", "Authorization: Bearer wrong-token\r\n").status, 401);
    EXPECT_EQ(get("/healthz").status, 401);
    EXPECT_EQ(server->counts().connections.wrong_tokens, 1U);
}

TEST_F(Limits, ARequestThatTricklesInIsClosed) {
    options.limits.request_time = std::chrono::milliseconds(50);
    start();
    TestClient slow(server->port());
    slow.send("GET /healthz HTTP/1.1\r\nHost: loc");
    EXPECT_TRUE(slow.at_end());
    TestClient silent(server->port());
    EXPECT_TRUE(silent.at_end());
}

TEST_F(Limits, FetchesAtOnceAreBounded) {
    options.limits.fetches = 1;
    start();
    TestClient first(server->port());
    first.get("/cameras/lobby/snapshot.jpg");
    ASSERT_TRUE(eventually([&] { return fetcher.request_count() == 1; }));
    EXPECT_EQ(get("/cameras/lobby/snapshot.jpg").status, 503);
    fetcher.answer(jpeg_unit("lobby", 1));
    EXPECT_EQ(first.read_reply().status, 200);
}

TEST_F(Limits, APictureThatNeverComesIsAnErrorAfterTheTimeLimit) {
    options.limits.reply_time = std::chrono::milliseconds(30);
    start();
    EXPECT_EQ(get("/cameras/lobby/snapshot.jpg?min_ns=999").status, 503);
}

TEST_F(Limits, ACommandThatRunsOnIsNotOneToRepeat) {
    options.limits.rpc_time = std::chrono::milliseconds(30);
    options.hooks.rpc = [](const std::string&, bool, const auto&) {};
    start();
    TestClient::Reply reply = post_rpc("{}");
    EXPECT_EQ(reply.status, 503);
    EXPECT_FALSE(reply.fields.contains("Retry-After"));
    EXPECT_EQ(reply.body.find("try again"), std::string::npos) << reply.body;
    EXPECT_NE(reply.body.find("may still be done"), std::string::npos) << reply.body;
    EXPECT_NE(reply.body.find("world.status"), std::string::npos) << reply.body;
}

TEST_F(Limits, ACommandThatMemoryRanOutForIsNotOneToRepeat) {
    options.hooks.rpc = [](const std::string&, bool, const auto&) { throw std::bad_alloc(); };
    start();
    const TestClient::Reply reply = post_rpc("{}");
    EXPECT_EQ(reply.status, 503);
    EXPECT_FALSE(reply.fields.contains("Retry-After"));
    EXPECT_NE(reply.body.find("may still be done"), std::string::npos) << reply.body;
}

TEST_F(Limits, AHookThatThrowsIsA500AndTheServerLivesOn) {
    options.hooks.rpc = [](const std::string&, bool, const auto&) { throw std::runtime_error("bug"); };
    start();
    EXPECT_EQ(post_rpc("{}").status, 500);
    EXPECT_EQ(get("/healthz").status, 200);
}

}  // namespace
}  // namespace camrig::http
