#pragma once

#include <chrono>
#include <cstddef>

#include "control/rpc/json_rpc.h"

namespace camrig::control {

/// The bounds of the control protocol; `server.info` and docs/control-protocol.md show them. The defaults are the
/// product's; tests shorten them.
struct ControlLimits {
    using Duration = std::chrono::milliseconds;

    std::size_t line_bytes = max_request_bytes;  ///< one message
    std::size_t connections = 64;                ///< on the Unix socket, and as many over TCP
    std::size_t unauthorized_connections = 8;    ///< over TCP, that have not shown the token yet
    std::size_t in_flight = 64;                  ///< of one connection, not answered yet; then it is not read
    std::size_t unsent_reply_bytes = std::size_t{4} << 20;    ///< of one connection; then it is not read
    std::size_t reply_bytes = std::size_t{80} << 20;          ///< one answer, or all of a batch; then it is an error
    std::size_t queued_reply_bytes = std::size_t{128} << 20;  ///< being made or unsent, of one connection; likewise
    std::size_t total_reply_bytes = std::size_t{512} << 20;   ///< of all, with the pictures being made; likewise
    std::size_t unauthorized_line_bytes = 4096;               ///< the first line where a token is asked for
    Duration authorize_time{5'000};                           ///< until that line is there
    Duration wrong_token{250};                                ///< before a wrong token is answered
    Duration stalled_after{10'000};                   ///< a client that takes no byte of a reply for so long is closed
    Duration linger{1'000};                           ///< to finish replies at the end, and to read off a line too long
    std::size_t linger_bytes = std::size_t{4} << 20;  ///< of that line; then the connection is closed at once
};

/// One picture of frame.get, before base64; larger ones go by HTTP.
inline constexpr std::size_t max_frame_bytes = std::size_t{48} << 20;
/// world.load requests that wait for the one in progress.
inline constexpr std::size_t max_scenes_waiting = 4;
/// plate.calibrate requests, likewise.
inline constexpr std::size_t max_searches_waiting = 4;

}  // namespace camrig::control
