#pragma once

#include <cstdint>
#include <string>

#include "core/base/result.h"
#include "core/base/unique_fd.h"

namespace camrig {

struct TcpListenerOptions {
    const char* name = "http";           ///< begins every message
    const char* port_option = "--http";  ///< what to choose another port with
    std::string host;                    ///< an address of this machine, or a name of one
    std::uint16_t port = 0;              ///< 0: any free one
    bool asks_for_token = false;         ///< who comes must show a token
};

/// A TCP socket that listens; it does not block.
struct TcpListener {
    UniqueFd fd;
    int family = 0;       ///< AF_INET or AF_INET6
    std::string address;  ///< as a number: "127.0.0.1"
    std::uint16_t port = 0;
};

/// "localhost" is 127.0.0.1, whatever the machine says of it: many clients know no other.
/// invalid_argument: the host is no address of this machine, or others can reach it and no token is asked for.
/// unavailable: the port is taken.
Result<TcpListener> listen_tcp(const TcpListenerOptions& options);

/// The first address that a name stands for, as a number. It may ask the network and wait. invalid_argument, with
/// `name` before the message: it stands for none.
Result<std::string> resolve_address(const char* name, const std::string& host);

/// 127.0.0.0/8, ::1 or "localhost": nobody else can reach it.
bool is_loopback_address(const std::string& host);
/// 0.0.0.0 or ::, all addresses of the machine.
bool is_any_address(const std::string& host);

}  // namespace camrig
