#pragma once

#include <chrono>
#include <cstddef>

namespace camrig {

/// The bounds of the control protocol; `server.info` shows them. The defaults are the product's; tests shorten them.
struct ControlLimits {
    using Duration = std::chrono::milliseconds;

    std::size_t line_bytes = 1 << 20;               ///< one message
    std::size_t batch = 64;                         ///< requests in one JSON-RPC batch
    std::size_t connections = 64;                   ///< Unix and TCP together
    std::size_t in_flight = 64;                     ///< messages of one connection not answered yet; then it is not read
    std::size_t unread_reply_bytes = 4U << 20;      ///< replies of one connection not sent yet; then it is not read
    std::size_t queued_reply_bytes = 128U << 20;    ///< the same; then it is closed
    std::size_t total_reply_bytes = 512U << 20;     ///< of all connections; then the one that asks for more is closed
    std::size_t frame_bytes = 48U << 20;            ///< one picture of frame.get, before base64
    std::size_t scenes_waiting = 4;                 ///< world.load requests waiting for the one in progress
    std::size_t unauthorized_line_bytes = 4096;     ///< the first line where a token is asked for
    Duration authorize_time{10'000};                ///< until that line is there
    Duration stalled_after{10'000};                 ///< a client that takes no byte of a reply for so long is closed
    Duration linger{1'000};                         ///< finishing replies at the end; reading off a line that is too long
};

}  // namespace camrig
