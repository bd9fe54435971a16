#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "rtsp_out/http/http_options.h"

namespace camrig::http {

/// MJPEG streams, pictures, JSON-RPC and statistics over HTTP/1.1 (docs/streams.md describes them for users).
///
/// One thread of its own serves all connections with coroutines; it never encodes or draws. Every bound is in
/// HttpLimits. All calls from any thread; hooks are called on the server's thread. Throws nothing.
class HttpServer {
public:
    /// Listens before it returns. invalid_argument: a host that is not loopback without a token, or a token that cannot
    /// travel; unavailable: the address cannot be listened on (the message says why).
    static Result<std::unique_ptr<HttpServer>> create(HttpOptions options);
    ~HttpServer();
    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    /// The port that is listened on.
    std::uint16_t port() const;
    /// The address that is listened on, in numbers: "127.0.0.1", "::1".
    std::string address() const;
    HttpCounts counts() const;
    /// Opens another port of the same host for a network camera: requests there go to HttpHooks::device with this name.
    /// Port 0 is any free one. `done` gets the port, or why it cannot be opened (unavailable), on the server's thread.
    void open_device_port(std::string device, std::uint16_t port, std::function<void(Result<std::uint16_t>)> done);
    /// Closes that port, after all calls before this one; its connections go on until they end. `done` gets whether
    /// there was such a port, on the server's thread.
    void close_device_port(std::string device, std::uint16_t port, std::function<void(bool)> done);
    /// Closes every connection and joins the thread. Twice is fine. Not from a hook.
    void stop();

private:
    struct Impl;
    explicit HttpServer(std::unique_ptr<Impl> impl);
    const std::unique_ptr<Impl> impl_;
};

}  // namespace camrig::http
