#include <future>

#include <gtest/gtest.h>

#include "server_fixture.h"

namespace camrig::http {
namespace {

class DevicePort : public ServerTest {
protected:
    DevicePort() {
        options.hooks.device = {.caller =
                                    [this](std::string_view method, std::string_view target,
                                           std::string_view authorization, bool shows_token) {
                                        const bool is_right =
                                            options.token.empty() || shows_token ||
                                            authorization == "Digest " + std::string(method) + std::string(target);
                                        return DeviceHooks::Caller{.rank = is_right ? std::optional(7) : std::nullopt,
                                                                   .challenge = "Digest realm=\"test\""};
                                    },
                                .call =
                                    [this](DeviceCall call, std::function<void(DeviceAnswer)> reply) {
                                        reply(answer);
                                        calls.push_back(std::move(call));
                                    }};
        fetcher.make = [](const stream::FetchRequest& request) { return jpeg_unit(request.camera, 12); };
    }
    Result<std::uint16_t> open(const std::string& device, std::uint16_t port = 0) {
        std::promise<Result<std::uint16_t>> opened;
        server->open_device_port(device, port, [&](Result<std::uint16_t> made) { opened.set_value(std::move(made)); });
        return opened.get_future().get();
    }
    bool close(const std::string& device, std::uint16_t port) {
        std::promise<bool> closed;
        server->close_device_port(device, port, [&](bool was_open) { closed.set_value(was_open); });
        return closed.get_future().get();
    }
    static TestClient::Reply ask(std::uint16_t port, std::string_view target, std::string_view fields = {}) {
        TestClient client(port);
        client.get(target, fields);
        return client.read_reply();
    }
    static TestClient::Reply post(std::uint16_t port, const std::string& body, const std::string& fields = {}) {
        TestClient client(port);
        client.send("POST /onvif/device_service HTTP/1.1\r\nHost: localhost:8081\r\n" + fields +
                    "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
        return client.read_reply();
    }

    DeviceAnswer answer{.content_type = "application/soap+xml", .text = "<a/>"};
    std::vector<DeviceCall> calls;  ///< the server's thread, until it has answered
};

TEST_F(DevicePort, HasMessagesAndPicturesOfItsCameraAndNothingElse) {
    start();
    const std::uint16_t port = *open("lobby");
    const auto reply = post(port, "<question/>");
    EXPECT_EQ(reply.status, 200);
    EXPECT_EQ(reply.body, "<a/>");
    EXPECT_EQ(reply.fields.at("Content-Type"), "application/soap+xml");
    ASSERT_EQ(calls.size(), 1U);
    EXPECT_EQ(calls[0].device, "lobby");
    EXPECT_EQ(calls[0].host, "localhost:8081");
    EXPECT_EQ(calls[0].body, "<question/>");
    EXPECT_EQ(calls[0].rank, 7);
    EXPECT_EQ(ask(port, "/cameras/lobby/snapshot.jpg").status, 200);
    EXPECT_EQ(ask(port, "/cameras/hall/snapshot.jpg").status, 404) << "another camera";
    for (const char* path : {"/", "/cameras", "/cameras/lobby/stream.mjpg", "/cameras/lobby/truth", "/rpc", "/metrics"})
        EXPECT_EQ(ask(port, path).status, 404) << path;
    EXPECT_EQ(ask(port, "/onvif/device_service").status, 405);
    EXPECT_EQ(get("/onvif/device_service").status, 404) << "on the rig's own port";
    EXPECT_EQ(ask(*open(""), "/cameras/hall/snapshot.jpg").status, 200) << "a device with all cameras";
}

TEST_F(DevicePort, IsCalledWithItsOwnPortWhateverTheClientLeavesOut) {
    start();
    const std::uint16_t port = *open("lobby");
    const std::string own = ":" + std::to_string(port);
    for (const auto& [given, told] : {std::pair<std::string, std::string>{"localhost", "localhost" + own},
                                      {"[::1]", "[::1]" + own},
                                      {"localhost:81", "localhost:81"},
                                      {"[::1]:81", "[::1]:81"}}) {
        TestClient client(port);
        client.send("POST /onvif/device_service HTTP/1.1\r\nHost: " + given + "\r\nContent-Length: 0\r\n\r\n");
        EXPECT_EQ(client.read_reply().status, 200);
        EXPECT_EQ(calls.back().host, told);
        EXPECT_EQ(calls.back().port, port);
    }
}

TEST_F(DevicePort, WhoSendsAMessageSlowlyIsClosedAndItIsNeverHeard) {
    options.limits.request_time = std::chrono::milliseconds(100);
    start();
    TestClient slow(*open("lobby"));
    slow.send("POST /onvif/device_service HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100\r\n\r\n<a");
    const std::string said = slow.read_to_end();
    EXPECT_TRUE(slow.at_end());
    EXPECT_FALSE(said.starts_with("HTTP/1.1 2")) << said;
    EXPECT_TRUE(calls.empty());
}

TEST_F(DevicePort, TheTokenIsShownByDigestAndMessagesSayThemselvesWhoSendsThem) {
    options.token = "a-good-token";
    start();
    const std::uint16_t port = *open("lobby");
    const auto refused = ask(port, "/cameras/lobby/snapshot.jpg");
    EXPECT_EQ(refused.status, 401);
    EXPECT_EQ(refused.fields.at("WWW-Authenticate"), "Digest realm=\"test\"");
    EXPECT_EQ(
        ask(port, "/cameras/lobby/snapshot.jpg", "Authorization: Digest GET/cameras/lobby/snapshot.jpg\r\n").status,
        200);
    EXPECT_EQ(post(port, "").status, 200);
    EXPECT_FALSE(calls.back().rank);
    EXPECT_EQ(post(port, "", "Authorization: Digest POST/onvif/device_service\r\n").status, 200);
    EXPECT_EQ(calls.back().rank, 7);
    answer.status = 401;
    answer.asks_digest = true;
    EXPECT_EQ(post(port, "").fields.at("WWW-Authenticate"), "Digest realm=\"test\"");
}

TEST_F(DevicePort, WrongTokensAreCountedAndAnsweredLate) {
    options.limits.wrong_token = std::chrono::milliseconds(30);
    answer.is_refused = true;
    start();
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_EQ(post(*open("lobby"), "").status, 200);
    EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(30));
    EXPECT_EQ(server->counts().connections.wrong_tokens, 1U);
}

TEST_F(DevicePort, MessagesAreBoundedAndThoseOfForeignPagesRefused) {
    start();
    const std::uint16_t port = *open("lobby");
    EXPECT_EQ(post(port, std::string(options.limits.device_body_bytes + 1, ' ')).status, 413);
    EXPECT_EQ(post(port, "", "Origin: http://elsewhere.example\r\n").status, 403);
    EXPECT_TRUE(calls.empty());
}

TEST_F(DevicePort, APortThatIsTakenIsAnErrorAndOneThatIsClosedIsFree) {
    start();
    const std::uint16_t port = *open("lobby");
    const auto taken = open("hall", port);
    ASSERT_FALSE(taken);
    EXPECT_EQ(taken.error().kind, ErrorKind::unavailable);
    EXPECT_FALSE(close("hall", port)) << "it never had it";
    EXPECT_EQ(post(port, "").status, 200);
    EXPECT_TRUE(close("lobby", port));
    EXPECT_FALSE(close("lobby", port));
    EXPECT_TRUE(open("hall", port));
    EXPECT_EQ(post(port, "").status, 200);
    EXPECT_EQ(calls.back().device, "hall");
}

}  // namespace
}  // namespace camrig::http
