#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "control/client/line_socket.h"
#include "control/client/rpc_client.h"
#include "control/server/control_server.h"
#include "tests/temporary_folder.h"
#include "tests/unit/control/fake_rig.h"

namespace camrig::control {

inline client::Deadline soon() {
    return std::chrono::steady_clock::now() + std::chrono::seconds(20);
}

/// Waits for what another thread will make true.
inline bool eventually(const std::function<bool()>& condition) {
    const client::Deadline deadline = soon();
    while (!condition()) {
        if (std::chrono::steady_clock::now() > deadline) return false;
        std::this_thread::yield();
    }
    return true;
}

/// A control server on a fake rig, at a Unix socket and, if wanted, at a free TCP port.
struct ServerHarness {
    explicit ServerHarness(ControlLimits limits = {}, bool with_tcp = false, std::string token = {})
        : rpc(RpcContext{rig, rig, {}, {}, token, limits, {}, {}, {}}) {
        ControlServerOptions options;
        options.unix_path = path;
        if (with_tcp) options.tcp_port = std::uint16_t{0};
        options.token = token;
        options.rpc = &rpc;
        options.limits = limits;
        auto created = ControlServer::create(std::move(options));
        EXPECT_TRUE(created) << (created ? "" : created.error().message);
        if (created) server = std::move(*created);
    }

    client::LineSocket connect() { return client::LineSocket::connect({.unix_path = path}, soon()).value(); }
    client::LineSocket connect_tcp() {
        return client::LineSocket::connect({.unix_path = {}, .host = "127.0.0.1", .port = server->tcp_port()}, soon())
            .value();
    }
    client::RpcClient client() { return client::RpcClient::connect({.endpoint = {.unix_path = path}}).value(); }

    TemporaryFolder folder;
    const std::string path = (folder / "s").string();
    FakeRig rig;
    RpcServer rpc;
    std::unique_ptr<ControlServer> server;
};

}  // namespace camrig::control
