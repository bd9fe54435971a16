#pragma once

#include <cstdint>
#include <memory>

#include "core/base/connection_counts.h"
#include "core/base/result.h"
#include "rtsp_out/rtsp/rtsp_options.h"

namespace camrig::rtsp {

/// Every camera as a network camera: rtsp://HOST:PORT/NAME (H.264 or H.265), /NAME/sub and /NAME/mjpeg, by UDP, TCP and
/// multicast.
///
/// gst-rtsp-server implements the protocol, on one thread with a GLib main loop of its own; each stream with clients
/// has a pipeline with its own threads. Cameras that are added, changed or deleted are noticed through the bus. Calls
/// from any thread.
class RtspServer {
public:
    /// invalid_argument: a host that needs a token, a bad certificate. unavailable: the port is taken.
    static Result<std::unique_ptr<RtspServer>> create(RtspOptions options);
    ~RtspServer();

    std::uint16_t port() const;
    /// "rtsp" or "rtsps".
    const char* scheme() const;
    ConnectionCounts counts() const;
    /// Ends all streams, closes all connections and joins. May be called twice.
    void stop();

private:
    struct Impl;
    explicit RtspServer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace camrig::rtsp
