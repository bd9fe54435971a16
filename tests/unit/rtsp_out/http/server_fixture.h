#pragma once

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "fakes.h"
#include "rtsp_out/http/http_server.h"
#include "test_client.h"

namespace camrig::http {

/// A server on a free port with a bus and a fetcher that the test drives. Change `options` before start().
class ServerTest : public testing::Test {
protected:
    ServerTest() {
        options.port = 0;
        options.bus = &bus;
        options.fetcher = &fetcher;
    }
    void start() {
        auto made = HttpServer::create(options);
        ASSERT_TRUE(made) << made.error().message;
        server = std::move(*made);
    }
    TestClient::Reply get(std::string_view target, std::string_view fields = {}) {
        TestClient client(server->port());
        client.get(target, fields);
        return client.read_reply();
    }
    TestClient::Reply post_rpc(const std::string& body,
                               const std::string& fields = "Content-Type: application/json\r\n") {
        TestClient client(server->port());
        client.send("POST /rpc HTTP/1.1\r\nHost: localhost\r\n" + fields +
                    "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
        return client.read_reply();
    }

    FakeBus bus;
    FakeFetcher fetcher;
    HttpOptions options;
    std::unique_ptr<HttpServer> server;  // goes first
};

}  // namespace camrig::http
