#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace camrig::client {

/// Where a rig's control protocol is reached: a Unix socket, or TCP when `host` is not empty.
struct Endpoint {
    std::string unix_path = {};
    std::string host = {};
    std::uint16_t port = 0;

    /// "HOST:PORT" or "[V6]:PORT" is TCP, all else a path. A path with a colon needs a slash: "./a:1".
    static Result<Endpoint> parse(std::string_view text);
    std::string to_string() const;
};

/// $CAMRIG_CONTROL, else $XDG_RUNTIME_DIR/camrig.sock, else /tmp/camrig-$UID.sock.
std::string default_control();

}  // namespace camrig::client
