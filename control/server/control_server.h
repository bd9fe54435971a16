#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "control/rpc/limits.h"
#include "control/rpc/rpc_server.h"
#include "core/base/connection_counts.h"
#include "core/base/result.h"

namespace camrig::control {

struct ControlServerOptions {
    /// Path of the Unix socket, made with mode 0600. A stale file of a rig that is gone is replaced; one where a rig
    /// answers is an error.
    std::string unix_path;
    std::string host = "127.0.0.1";
    std::optional<std::uint16_t> tcp_port;         ///< nullopt: no TCP; 0: any free port
    std::string token;                             ///< asked for on TCP; required unless host is loopback
    Authority tcp_authority = Authority::command;  ///< of a TCP client that has shown the token, or where none is asked
    RpcServer* rpc = nullptr;                      ///< outlives the server
    ControlLimits limits = {};
};

/// JSON-RPC over lines: one JSON message a line, answers in the order of the requests of a connection.
///
/// One thread of its own serves all connections with coroutines. Every bound is in ControlLimits. All calls from any
/// thread; throws nothing.
class ControlServer {
public:
    /// Listens before it returns. already_exists: another rig lives at unix_path; invalid_argument: a host beyond
    /// loopback without a token; unavailable: cannot be listened on (the message says why).
    static Result<std::unique_ptr<ControlServer>> create(ControlServerOptions options);
    ~ControlServer();
    ControlServer(const ControlServer&) = delete;
    ControlServer& operator=(const ControlServer&) = delete;

    /// 0 when there is no TCP.
    std::uint16_t tcp_port() const;
    /// The address of TCP in numbers: "127.0.0.1", "::1"; empty when there is none.
    std::string tcp_address() const;
    ConnectionCounts counts() const;
    /// Takes no more requests, gives answers in work a moment (limits.linger), closes every connection, removes the
    /// socket file and joins the thread. Twice is fine.
    void stop();

private:
    struct Impl;
    explicit ControlServer(std::unique_ptr<Impl> impl);
    const std::unique_ptr<Impl> impl_;
};

}  // namespace camrig::control
