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

/// A request to a network camera (ONVIF's SOAP messages), on a port of HttpServer::open_device_port().
struct DeviceCall {
    std::string device;            ///< the name that the port was opened with
    std::string host;              ///< the Host field: name or address, and port
    std::uint16_t port = 0;        ///< local port
    std::string path;              ///< of the URL
    std::optional<int> rank = {};  ///< what the client may do by its HTTP authentication (DeviceHooks::Caller)
    bool shows_wrong = false;      ///< it sent HTTP credentials that are wrong
    std::string challenge = {};    ///< WWW-Authenticate of the answer, should that be 401
    std::string body;
};
struct DeviceAnswer {
    int status = 200;
    std::string content_type, text;
    bool is_refused = false;   ///< the credentials inside the message (WS-UsernameToken) were wrong
    bool asks_digest = false;  ///< 401: the client shall authenticate by HTTP digest (DeviceCall::challenge)
};

/// Network cameras (ONVIF), as the composition root implements them. Either both functions are given or none.
struct DeviceHooks {
    struct Caller {
        std::optional<int> rank = {};  ///< a level that `call` understands; nullopt: may not even see pictures
        bool is_stale = false;         ///< the password is right, but the digest's nonce is too old or used
        std::string challenge = {};    ///< WWW-Authenticate, for a client without a rank
    };
    /// Who a request is from, by its Authorization field, which may be empty. `shows_token`: it carries the rig's own
    /// token, as on the rig's port. Answers at once.
    std::function<Caller(std::string_view method, std::string_view target, std::string_view authorization,
                         bool shows_token)>
        caller;
    /// Handles a message.
    std::function<void(DeviceCall, std::function<void(DeviceAnswer)> reply)> call;
};

/// What the composition root plugs in. Every hook is called on the server's thread and must not block; a `reply` may be
/// called once, later, from any thread, also after the server is gone.
struct HttpHooks {
    using Rpc = std::function<void(std::string body, bool may_command, std::function<void(RpcText)> reply)>;
    using Stats = std::function<void(std::function<void(stream::RigReport)> reply)>;
    using Truth =
        std::function<void(std::string camera, TimeNs min_ns, std::function<void(Result<std::string>)> reply)>;

    Rpc rpc;      ///< JSON-RPC text in and out. An answer without pieces is sent as "204 No Content"
    Stats stats;  ///< for /metrics
    Truth truth;  ///< JSON text of /cameras/NAME/truth
    std::function<std::optional<StaticFile>(std::string_view path)> files;  ///< the web page. Absent: there is none
    DeviceHooks device;  ///< of ports of HttpServer::open_device_port()
};

/// Bounds. The defaults are the product's; tests shorten the times.
struct HttpLimits {
    using Duration = std::chrono::milliseconds;

    std::size_t connections = 512;
    std::size_t waiting_connections = 128;               ///< those whose next request has not arrived whole
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
    Duration reopen_after{1'000};        ///< a stream of several cameras asks again for one that threw it out
    Duration wrong_token{250};           ///< delay of the answer to a wrong token
    Duration linger{2'000};              ///< how long to read what a refused client still sends, before closing
};

struct HttpOptions {
    std::string host = "127.0.0.1";  ///< address or name to listen on
    std::uint16_t port = 8080;       ///< 0: any free port
    std::string token;               ///< every request must carry it; empty: none; required unless `host` is loopback
    std::string command_key;         ///< without a token: `POST /rpc` must carry it to change anything; empty: need not
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
