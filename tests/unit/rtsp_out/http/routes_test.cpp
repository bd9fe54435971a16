#include <cstring>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "server_fixture.h"

namespace camrig::http {
namespace {

using Routes = ServerTest;

std::string kind_of(const TestClient::Reply& reply) {
    const auto body = nlohmann::json::parse(reply.body, nullptr, false);
    return body.is_object() ? body["error"]["kind"].get<std::string>() : "no JSON: " + reply.body;
}

TEST_F(Routes, CamerasAreListedWithTheirUrls) {
    start();
    const auto reply = get("/cameras");
    EXPECT_EQ(reply.status, 200);
    const auto list = nlohmann::json::parse(reply.body)["cameras"];
    ASSERT_EQ(list.size(), 2U);
    EXPECT_EQ(list[0]["name"], "lobby");
    EXPECT_EQ(list[0]["size"], (nlohmann::json{64, 48}));
    EXPECT_EQ(list[0]["fps"], 25);
    EXPECT_EQ(list[1]["fps"], "30000/1001");
    EXPECT_EQ(list[0]["urls"]["stream"], "/cameras/lobby/stream.mjpg");
}

TEST_F(Routes, ASnapshotIsTheFetchersPictureWithItsFrameNumbers) {
    fetcher.make = [](const stream::FetchRequest& request) { return jpeg_unit(request.camera, 12); };
    start();
    const auto reply = get("/cameras/lobby/snapshot.jpg?quality=30&min_ns=7");
    EXPECT_EQ(reply.status, 200);
    EXPECT_EQ(reply.fields.at("Content-Type"), "image/jpeg");
    EXPECT_EQ(reply.fields.at("X-Sequence"), "12");
    EXPECT_EQ(reply.fields.at("X-World-Time-Ns"), "480000000");
    EXPECT_EQ(reply.fields.at("Cache-Control"), "no-store");
    const std::string etag = reply.fields.at("ETag");
    EXPECT_TRUE(etag.starts_with("\"12-")) << etag;
    EXPECT_EQ(reply.body.size(), 100U);
    EXPECT_FALSE(reply.fields.contains("Access-Control-Allow-Origin"));
    EXPECT_EQ(fetcher.requests.at(0).format.quality, 30);
    EXPECT_EQ(fetcher.requests.at(0).min_ns, 7);
    const auto same = get("/cameras/lobby/snapshot.jpg", "If-None-Match: " + etag + "\r\n");
    EXPECT_EQ(same.status, 304);
    EXPECT_EQ(same.fields.at("ETag"), etag);
    EXPECT_EQ(same.body, "");
    // The camera was changed, and the world stands.
    fetcher.make = [](const stream::FetchRequest& request) -> Result<stream::MediaUnit> {
        auto unit = jpeg_unit(request.camera, 12);
        auto other = std::make_shared<std::vector<std::byte>>(*unit.bytes);
        other->back() ^= std::byte{1};
        unit.bytes = other;
        return unit;
    };
    EXPECT_EQ(get("/cameras/lobby/snapshot.jpg", "If-None-Match: " + etag + "\r\n").status, 200);
}

TEST_F(Routes, DepthComesAsNpyOfItsFloats) {
    fetcher.make = [](const stream::FetchRequest& request) -> Result<stream::MediaUnit> {
        EXPECT_EQ(request.kind, frame::FrameKind::depth);
        stream::MediaUnit unit = jpeg_unit(request.camera, 1);
        unit.bytes.reset();
        unit.info.size = {16, 17};
        unit.info.format = frame::PixelFormat::depth32f;
        const std::vector<float> metres(16 * 17, 2.5F);
        std::vector<std::byte> bytes(metres.size() * 4);
        std::memcpy(bytes.data(), metres.data(), bytes.size());
        unit.frame = std::make_shared<const frame::Frame>(unit.info, bytes);
        return unit;
    };
    start();
    const auto reply = get("/cameras/lobby/depth.npy");
    EXPECT_EQ(reply.status, 200);
    ASSERT_EQ(reply.body.size() % 64, 16U * 17 * 4 % 64);
    EXPECT_NE(reply.body.find("'shape': (17, 16)"), std::string::npos);
    float last = 0;
    std::memcpy(&last, reply.body.data() + reply.body.size() - 4, 4);
    EXPECT_EQ(last, 2.5F);
}

TEST_F(Routes, ErrorsOfTheRigBecomeStatusAndJson) {
    fetcher.make = [](const stream::FetchRequest&) { return error(ErrorKind::not_found, "no camera 'x'"); };
    start();
    EXPECT_EQ(get("/cameras/x/snapshot.jpg").status, 404);
    EXPECT_EQ(kind_of(get("/cameras/x/snapshot.png")), "not_found");
    EXPECT_EQ(get("/cameras/x/stream.mjpg").status, 404);
    EXPECT_EQ(get("/cameras/lobby/truth").status, 501);
    EXPECT_EQ(get("/cameras/lobby/stream.mjpg?quality=0").status, 400);
    EXPECT_EQ(get("/cameras/lobby/snapshot.png?width=1").status, 400);
    EXPECT_EQ(get("/cameras?x=1").status, 400);
    EXPECT_EQ(get("/nothing").status, 404);
    EXPECT_EQ(get("/../etc/passwd").status, 400);
    EXPECT_EQ(get("/cameras/%2e%2e/x").status, 400);
    EXPECT_EQ(get("/a%00b").status, 400);
}

TEST_F(Routes, TruthComesFromItsHook) {
    options.hooks.truth = [](const std::string& camera, TimeNs min_ns, const auto& reply) {
        EXPECT_EQ(min_ns, 5);
        reply("{\"camera\":\"" + camera + "\"}");
    };
    start();
    const auto reply = get("/cameras/lobby/truth?min_ns=5");
    EXPECT_EQ(reply.status, 200);
    EXPECT_EQ(reply.body, "{\"camera\":\"lobby\"}");
}

TEST_F(Routes, RpcMayAnswerLaterFromAnotherThread) {
    std::thread later;
    options.hooks.rpc = [&later](std::string body, bool, std::function<void(RpcText)> reply) {
        later = std::thread([body = std::move(body), reply = std::move(reply)] { reply(RpcText{{"[", body, "]"}}); });
    };
    start();
    const auto reply = post_rpc("{\"id\":1}", "Content-Type: application/json; charset=utf-8\r\n");
    later.join();
    EXPECT_EQ(reply.status, 200);
    EXPECT_EQ(reply.body, "[{\"id\":1}]");
    EXPECT_EQ(reply.fields.at("Content-Type"), "application/json");
}

TEST_F(Routes, RpcIsForJsonFromProgramsAndOwnPagesOnly) {
    int asked = 0;
    options.hooks.rpc = [&asked](const std::string&, bool, const auto& reply) {
        ++asked;
        reply(RpcText{});
    };
    start();
    const std::string json = "Content-Type: application/json\r\n";
    EXPECT_EQ(post_rpc("{}").status, 204);
    EXPECT_EQ(post_rpc("{}", json + "Origin: http://localhost\r\n").status, 204);
    EXPECT_EQ(asked, 2);
    EXPECT_EQ(post_rpc("{}", "Content-Type: text/plain\r\n").status, 415);
    EXPECT_EQ(post_rpc("{}", "").status, 415);
    EXPECT_EQ(post_rpc("{}", json + "Origin: http://evil.example\r\n").status, 403);
    EXPECT_EQ(post_rpc("{}", json + "Sec-Fetch-Site: cross-site\r\n").status, 403);
    EXPECT_EQ(get("/rpc").status, 405);
    EXPECT_EQ(asked, 2);
}

TEST_F(Routes, WithoutTheKeyAndWithAWrongOneARequestMayOnlyLook) {
    options.command_key = "0123456789abcdef";
    options.hooks.rpc = [](const std::string&, bool may_command, const auto& reply) {
        reply(RpcText{{may_command ? "[1]" : "[0]"}});
    };
    start();
    const std::string json = "Content-Type: application/json\r\n";
    EXPECT_EQ(post_rpc("{}", json + "Authorization: Bearer 0123456789abcdef\r\n").body, "[1]");
    for (const char* field : {"", "Authorization: Bearer 0123456789abcdeX\r\n", "Authorization: Bearer \r\n",
                              "Authorization: Basic 0123456789abcdef\r\n"})
        EXPECT_EQ(post_rpc("{}", json + field).body, "[0]") << field;
    EXPECT_EQ(get("/cameras").status, 200);
}

TEST_F(Routes, AForeignHostNameIsRefused) {
    start();
    TestClient client(server->port());
    client.send("GET /cameras HTTP/1.1\r\nHost: evil.example\r\n\r\n");
    EXPECT_EQ(client.read_reply().status, 403);
    TestClient none(server->port());
    none.send("GET /cameras HTTP/1.1\r\n\r\n");
    EXPECT_EQ(none.read_reply().status, 400);
}

TEST_F(Routes, WhatTwoProgramsCouldReadInTwoWaysIsRefusedAndNothingAfterItIsRead) {
    int asked = 0;
    options.hooks.rpc = [&asked](const std::string&, bool, const auto& reply) {
        ++asked;
        reply(RpcText{});
    };
    start();
    const std::string smuggled = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";
    for (const char* encoding :
         {"xchunked", "chunked, gzip", "identity", "gzip, chunked", "chunked\r\nTransfer-Encoding: x"}) {
        TestClient client(server->port());
        client.send("POST /rpc HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nTransfer-Encoding: " +
                    std::string(encoding) + "\r\n\r\n" + smuggled);
        const int status = client.read_reply().status;
        EXPECT_TRUE(status == 501 || status == 400) << encoding << ": " << status;
        EXPECT_TRUE(client.at_end()) << encoding;
    }
    EXPECT_EQ(asked, 0);
    for (const char* host : {"localhost\r\nHost: localhost", "[::1]evil.example", "[::1", "localhost:80:80", "a b", "",
                             ":80", "localhost@evil.example"}) {
        TestClient client(server->port());
        client.send("GET /healthz HTTP/1.1\r\nHost: " + std::string(host) + "\r\n\r\n" + smuggled);
        EXPECT_EQ(client.read_reply().status, 400) << host;
        EXPECT_TRUE(client.at_end()) << host;
    }
}

TEST_F(Routes, AMethodIsTakenByItsWholeName) {
    start();
    for (const char* method : {"GE", "ET", "get", "HEA", "OPTION", "T, H"}) {
        TestClient client(server->port());
        client.send(std::string(method) + " /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
        const auto reply = client.read_reply();
        EXPECT_TRUE(reply.status == 405 || reply.status == 400) << method << ": " << reply.status;
    }
}

// <img src="http://127.0.0.1:8080/cameras/lobby/depth.png?t=N"> in a page of anybody.
TEST_F(Routes, NothingIsDrawnForPagesOfOtherOrigins) {
    fetcher.make = [](const stream::FetchRequest& request) { return jpeg_unit(request.camera, 1); };
    options.hooks.truth = [](const std::string&, TimeNs, const auto& reply) { reply("{}"); };
    options.embedders = {"http://dash.example:3000"};
    start();
    for (const char* path : {"/cameras/lobby/depth.png?t=1", "/cameras/lobby/snapshot.jpg", "/cameras/lobby/truth",
                             "/cameras/lobby/stream.mjpg", "/live?cameras=lobby", "/metrics"}) {
        for (const char* field : {"Sec-Fetch-Site: cross-site", "Sec-Fetch-Site: same-site",
                                  "Referer: http://evil.example/", "Origin: null"})
            EXPECT_EQ(get(path, std::string(field) + "\r\n").status, 403) << path << " " << field;
    }
    EXPECT_EQ(fetcher.request_count(), 0U);
    EXPECT_EQ(bus.reader_count(), 0U);
    for (const char* field :
         {"", "Sec-Fetch-Site: same-origin\r\n", "Sec-Fetch-Site: none\r\n", "Referer: http://localhost/\r\n"}) {
        const auto reply = get("/cameras/lobby/snapshot.jpg", field);
        EXPECT_EQ(reply.status, 200) << field;
        EXPECT_EQ(reply.fields.at("Cross-Origin-Resource-Policy"), "same-origin");
    }
    const std::string listed = "Sec-Fetch-Site: cross-site\r\nReferer: http://dash.example:3000/\r\n";
    const auto reply = get("/cameras/lobby/snapshot.jpg", listed);
    EXPECT_EQ(reply.status, 200);
    EXPECT_EQ(reply.fields.at("Cross-Origin-Resource-Policy"), "cross-origin");
    TestClient stream(server->port());
    stream.get("/cameras/lobby/stream.mjpg", listed);
    EXPECT_EQ(stream.read_head().fields.at("Cross-Origin-Resource-Policy"), "cross-origin");
}

TEST_F(Routes, TheTokenIsAskedForEverywhere) {
    options.token = "correct-token";
    fetcher.make = [](const stream::FetchRequest& request) { return jpeg_unit(request.camera, 1); };
    options.hooks.files = [](std::string_view) {
        return StaticFile{"text/html", std::make_shared<const std::string>()};
    };
    start();
    for (const char* path :
         {"/", "/cameras", "/live?cameras=lobby", "/healthz", "/metrics", "/cameras/lobby/snapshot.jpg",
          "/cameras/lobby/stream.mjpg", "/rpc", "/nothing", "/cameras?token=wrong-token!"}) {
        const auto reply = get(path);
        EXPECT_EQ(reply.status, 401) << path;
        EXPECT_TRUE(reply.fields.contains("WWW-Authenticate"));
        EXPECT_EQ(kind_of(reply), "unauthorized");
    }
    EXPECT_EQ(post_rpc("{}").status, 401);
    EXPECT_EQ(get("/cameras", "Authorization: Bearer correct-token\r\n").status, 200);
    EXPECT_EQ(get("/cameras/lobby/snapshot.jpg?token=correct-token").status, 200);
    const auto page = get("/?token=correct-token");
    EXPECT_EQ(page.status, 200);
    EXPECT_EQ(page.fields.at("Set-Cookie"), "camrig_token=correct-token; Path=/; HttpOnly; SameSite=Strict");
    EXPECT_EQ(get("/app.js", "Cookie: camrig_token=correct-token\r\n").status, 200);
}

TEST_F(Routes, HealthzIsOkAndMetricsAnswerFromTheirHook) {
    options.hooks.stats = [](const auto& reply) {
        stream::RigReport report;
        report.instants = 42;
        reply(report);
    };
    start();
    EXPECT_EQ(get("/healthz").body, "ok\n");
    const auto metrics = get("/metrics");
    EXPECT_TRUE(metrics.fields.at("Content-Type").starts_with("text/plain; version=0.0.4"));
    EXPECT_NE(metrics.body.find("camrig_instants_total 42\n"), std::string::npos);
    EXPECT_NE(metrics.body.find("camrig_http_requests_total 1\n"), std::string::npos);
}

TEST_F(Routes, ThePageAndItsPartsComeFromTheHook) {
    start();
    EXPECT_EQ(get("/").status, 404);
    options.hooks.files = [](std::string_view path) -> std::optional<StaticFile> {
        if (path != "/app.js") return std::nullopt;
        return StaticFile{"text/javascript", std::make_shared<const std::string>("1")};
    };
    start();
    const auto part = get("/app.js");
    EXPECT_EQ(part.body, "1");
    EXPECT_TRUE(part.fields.contains("Content-Security-Policy"));
    EXPECT_EQ(get("/").status, 404);
}

TEST_F(Routes, HeadIsGetWithoutTheBodyAndOptionsNamesTheMethods) {
    fetcher.make = [](const stream::FetchRequest& request) { return jpeg_unit(request.camera, 1); };
    start();
    TestClient client(server->port());
    client.send("HEAD /cameras/lobby/snapshot.jpg HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(client.read_head().fields.at("Content-Length"), "100");
    client.send("OPTIONS /cameras HTTP/1.1\r\nHost: localhost\r\n\r\n");
    auto reply = client.read_head();
    EXPECT_EQ(reply.status, 204);
    EXPECT_EQ(reply.fields.at("Allow"), "GET, HEAD, OPTIONS");
    client.send("DELETE /cameras HTTP/1.1\r\nHost: localhost\r\n\r\n");
    reply = client.read_reply();
    EXPECT_EQ(reply.status, 405);
    EXPECT_EQ(reply.fields.at("Allow"), "GET, HEAD, OPTIONS");
    client.send("HEAD /cameras/lobby/stream.mjpg HTTP/1.1\r\nHost: localhost\r\n\r\n");
    reply = client.read_head();
    EXPECT_EQ(reply.fields.at("Content-Type"), "multipart/x-mixed-replace; boundary=frame");
    EXPECT_TRUE(client.at_end());
    EXPECT_EQ(bus.reader_count(), 0U);
    TestClient other(server->port());
    other.send("HEAD /cameras/nobody/stream.mjpg HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(other.read_head().status, 404);
    TestClient live(server->port());
    live.send("HEAD /live?cameras=lobby HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(live.read_head().fields.at("Content-Type"), "multipart/mixed; boundary=frame");
    EXPECT_TRUE(live.at_end());
    EXPECT_EQ(bus.reader_count(), 0U);
}

TEST_F(Routes, HeadOfAStreamSaysWhatGetWould) {
    bus.known.front().standing.refused = 1U << static_cast<unsigned>(fault::Output::mjpeg);
    start();
    for (const auto& [target, status] : {std::pair{"/cameras/lobby/stream.mjpg", 503},
                                         {"/cameras/hall/stream.mjpg", 200},
                                         {"/live?cameras=nobody", 404},
                                         {"/live?cameras=hall,nobody", 404},
                                         {"/live?cameras=lobby,hall", 200}}) {
        for (const std::string method : {"HEAD", "GET"}) {
            TestClient client(server->port());
            client.send(method + " " + target + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
            EXPECT_EQ(client.read_head().status, status) << method << " " << target;
        }
    }
}

TEST_F(Routes, AConnectionServesManyRequestsAlsoPipelined) {
    start();
    TestClient client(server->port());
    const std::string one = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";
    client.send(one + one + one);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(client.read_reply().body, "ok\n");
    client.send("GET /healthz HTTP/1.0\r\n\r\n");
    EXPECT_EQ(client.read_reply().fields.at("Connection"), "close");
    EXPECT_TRUE(client.at_end());
}

}  // namespace
}  // namespace camrig::http
