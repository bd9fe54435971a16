#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "control/rpc/rpc_server.h"
#include "core/base/result.h"

namespace camrig {

struct ControlServerOptions {
    /// Path of the Unix socket, made with mode 0600. A stale file of a rig that is gone is replaced; one where a rig answers is
    /// an error.
    std::string unix_path;
    std::string host = "127.0.0.1";
    std::optional<std::uint16_t> tcp_port;  ///< nullopt: no TCP; 0: any free port
    std::string token;                      ///< asked for on TCP; required unless host is loopback
    RpcServer* rpc = nullptr;               ///< outlives the server
};

/// JSON-RPC over lines: one JSON message a line, answers in the order of the requests of a connection.
///
/// One thread of its own serves all connections with coroutines. Every bound is named in the implementation and in
/// docs/control-protocol.md. All calls from any thread.
class ControlServer {
public:
    /// Listens before it returns.
    static Result<std::unique_ptr<ControlServer>> create(ControlServerOptions options);
    ~ControlServer();
    ControlServer(const ControlServer&) = delete;
    ControlServer& operator=(const ControlServer&) = delete;

    /// 0 when there is no TCP.
    std::uint16_t tcp_port() const;
    /// Closes every connection, removes the socket file and joins the thread. Twice is fine.
    void stop();

private:
    struct Impl;
    explicit ControlServer(std::unique_ptr<Impl> impl);
    const std::unique_ptr<Impl> impl_;
};

}  // namespace camrig
