#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/stream/frame_bus.h"
#include "rtsp_out/rtsp/request_bounds.h"
#include "rtsp_out/rtsp/video_encoder.h"

namespace camrig::rtsp {

/// Bounds. The defaults are the product's; tests shorten them.
struct RtspLimits {
    std::size_t connections = 512;
    /// Most connections of strangers among these: clients that have not authenticated or, where no token is set, have
    /// set up no stream. The oldest one is closed for a new one.
    std::size_t strangers = 256;
    std::size_t strangers_per_address = 128;
    int stranger_quiet_ms = 10'000;  ///< a stranger is closed so long after connecting or its last good request
    int request_ms = 10'000;         ///< a client whose request takes longer to arrive is closed
    int wrong_tokens = 3;            ///< a client that has sent so many on one connection is closed
    RequestLimits requests;
    int send_buffer_bytes = 256 * 1024;       ///< the kernel's, per connection
    int stalled_after_ms = 6'000;             ///< a TCP client that takes no byte for so long is closed
    std::size_t sessions_per_connection = 8;  ///< made by SETUP without one; most clients make one
    unsigned sessions = 1024;                 ///< of all connections
    int session_timeout_s = 60;               ///< a UDP client that says nothing (RTSP or RTCP) for so long is gone
};

struct RtspOptions {
    std::string host = "127.0.0.1";  ///< address to listen on
    std::uint16_t port = 8554;       ///< 0: any free port
    std::string token;               ///< empty: none; required unless `host` is loopback. User "camrig", password token
    std::filesystem::path certificate;        ///< PEM; with it the port speaks RTSPS only
    std::filesystem::path key;                ///< PEM; empty: it is in the certificate's file
    stream::FrameBus* bus = nullptr;          ///< outlives the server
    stream::FrameFetcher* fetcher = nullptr;  ///< outlives the server
    std::vector<std::string> h264_elements = rtsp::h264_elements;
    RtspLimits limits;
};

inline constexpr const char* rtsp_user = "camrig";

}  // namespace camrig::rtsp
