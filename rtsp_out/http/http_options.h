#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/connection_counts.h"
#include "core/base/result.h"
#include "core/base/time.h"
#include "core/stream/frame_bus.h"
#include "core/stream/statistics.h"

namespace camrig::http {

/// A file of the web page.
struct StaticFile {
    std::string content_type;
    std::shared_ptr<const std::string> bytes;
};

/// The text of a JSON-RPC answer: one piece after the other. `keep` goes when it has been sent.
struct RpcText {
    std::vector<std::string> pieces;
    std::shared_ptr<const void> keep = {};
};

/// A message to a network camera, which came on a port of HttpServer::open_device_port().
struct DeviceCall {
    std::string device;            ///< what the port was opened for
    std::string host;              ///< as the client calls us: name or address, and the port
    std::uint16_t port = 0;        ///< that it came to
    std::string path;              ///< of the URL that was posted to
    std::optional<int> rank = {};  ///< of who asks, by HTTP: as DeviceHooks::caller says
    bool shows_wrong = false;      ///< what is shown is not right
    std::string challenge = {};    ///< WWW-Authenticate, should one be asked to show something
    std::string body;
};
struct DeviceAnswer {
    int status = 200;
    std::string content_type, text;
    bool is_refused = false;   ///< it came with a wrong token
    bool asks_digest = false;  ///< the client is to come again with HTTP digest
};

/// What network cameras answer (ONVIF). Both or none are given; the first answers at once.
struct DeviceHooks {
    struct Caller {
        std::optional<int> rank = {};  ///< whatever it means to `call`; nullopt: nobody who may see pictures
        bool is_stale = false;         ///< has shown what was right a while ago
        std::string challenge = {};    ///< WWW-Authenticate, for who has no rank
    };
    /// Who asks, by the Authorization field of this request, which may be empty.
    /// `shows_token`: the rig's, as on its other ports.
    std::function<Caller(std::string_view method, std::string_view target, std::string_view authorization,
                         bool shows_token)>
        caller;
    std::function<void(DeviceCall, std::function<void(DeviceAnswer)> reply)> call;
};

/// What the composition root plugs in. Every hook is called on the server's thread and must not block; a `reply` may be
/// called once, later, from any thread, also after the server is gone.
struct HttpHooks {
    using Rpc = std::function<void(std::string body, bool may_command, std::function<void(RpcText)> reply)>;
    using Stats = std::function<void(std::function<void(stream::RigReport)> reply)>;
    using Truth =
        std::function<void(std::string camera, TimeNs min_ns, std::function<void(Result<std::string>)> reply)>;

    Rpc rpc;      ///< JSON-RPC text in and out. No pieces: "204 No Content"
    Stats stats;  ///< for /metrics
    Truth truth;  ///< JSON text of /cameras/NAME/truth
    std::function<std::optional<StaticFile>(std::string_view path)> files;  ///< the web page. Absent: there is none
    DeviceHooks device;  ///< of ports of HttpServer::open_device_port()
};

/// Bounds. The defaults are the product's; tests shorten the times.
struct HttpLimits {
    using Duration = std::chrono::milliseconds;

    std::size_t connections = 512;
    std::size_t waiting_connections = 128;               ///< that have no whole request in work
    std::size_t connections_per_peer = 128;              ///< of one address beyond loopback
    std::size_t connections_per_local_peer = 512;        ///< of one address of loopback
    std::size_t header_bytes = 16 * 1024;                ///< request line and header fields together
    std::size_t body_bytes = 1024 * 1024;                ///< of POST /rpc
    std::size_t device_body_bytes = 256 * 1024;          ///< of a message to a network camera
    std::size_t fetches = 64;                            ///< pictures and truths being made at once, for all clients
    std::size_t picture_bytes = std::size_t{512} << 20;  ///< of pictures being made or sent, for all clients
    std::size_t qualities_per_camera =
        8;  ///< different qualities and widths streamed at once (each is one more encoding)
    int send_buffer_bytes = 256 * 1024;  ///< the kernel's, per connection
    int unsent_bytes = 64 * 1024;        ///< TCP_NOTSENT_LOWAT: what waits in the kernel is stale
    Duration request_time{10'000};       ///< a whole request, from the end of the last one
    Duration stalled_after{10'000};      ///< a client that takes no byte for so long is closed
    Duration reply_time{30'000};         ///< waiting for a picture, a truth or statistics
    Duration device_time{90'000};        ///< waiting for a network camera's answer (events are waited for a minute)
    Duration rpc_time{600'000};          ///< waiting for a JSON-RPC answer (world.step may take long)
    Duration repeat_after{2'000};        ///< a stream without a new picture repeats the last one
    Duration wrong_token{250};           ///< before a wrong token is answered
    Duration linger{2'000};              ///< reading what a refused client still sends, so that it sees the answer
};

struct HttpOptions {
    std::string host = "127.0.0.1";           ///< address or name to listen on
    std::uint16_t port = 8080;                ///< 0: any free port
    std::string token;                        ///< of every request; empty: none; required unless `host` is loopback
    std::string command_key;                  ///< without a token: what a `POST /rpc` shows to command; empty: all may
    stream::FrameBus* bus = nullptr;          ///< outlives the server
    stream::FrameFetcher* fetcher = nullptr;  ///< outlives the server
    std::vector<std::string> embedders;       ///< origins of pages that may show pictures (asking_page.h)
    HttpHooks hooks;
    HttpLimits limits;
};

/// Counts since the start.
struct HttpCounts {
    ConnectionCounts connections;
    std::uint64_t requests = 0;
    std::uint64_t errors = 0;  ///< replies with status 400 and above
    std::uint64_t streams_open = 0;
    std::uint64_t first_parts = 0;     ///< pictures fetched to open a stream; not in the readers' books
    std::uint64_t repeated_parts = 0;  ///< pictures sent again because nothing new came; not in the readers' books
    std::uint64_t stalled = 0;         ///< streams closed for taking nothing
};

}  // namespace camrig::http
