#pragma once

#include <deque>
#include <functional>
#include <string>

#include <gst/rtsp-server/rtsp-server.h>

#include "core/base/log_pace.h"
#include "core/base/result.h"
#include "core/base/tcp_listener.h"
#include "rtsp_out/rtsp/gst_handle.h"

namespace camrig::rtsp {

/// Accepts TCP connections for an RTSP server, and pauses while the process is short of file descriptors.
///
/// gst-rtsp-server's own accept loop busy-waits without descriptors. During a pause (core/base/descriptors.h) new
/// connections wait in the kernel's backlog. Server thread, but for create().
class RtspListener {
public:
    static constexpr TimeNs wait_ns = ns_per_s;     ///< how long a throttled connection is left unread
    static constexpr std::size_t max_waiting = 64;  ///< of those; the oldest is closed for one more

    struct Hooks {
        std::function<bool(const std::string& address)> admit;      ///< false: the connection is closed
        std::function<void()> shed;                                 ///< descriptors are short: close some connection
        std::function<bool(const std::string& address)> must_wait;  ///< its address is throttled after failed logins
        std::function<void(GSocket* socket)> prepare;               ///< called before the server gets the socket
    };

    static Result<std::unique_ptr<RtspListener>> create(GstRTSPServer* server, TcpListener listener, Hooks hooks);
    ~RtspListener();
    RtspListener(const RtspListener&) = delete;
    RtspListener& operator=(const RtspListener&) = delete;

    std::uint16_t port() const { return port_; }
    /// What it listens on, as a number: "127.0.0.1".
    const std::string& address() const { return address_; }
    void start(GMainContext* context);
    void stop();
    /// Hands over throttled connections whose time is up, and resumes accepting after a pause. To be called at least
    /// once a second.
    void look_after(TimeNs now_ns);

private:
    struct Waiting {
        GObjectHandle<GSocket> socket;
        TimeNs until_ns = 0;
    };

    RtspListener(GstRTSPServer* server, const TcpListener& listener, Hooks hooks, GObjectHandle<GSocket> socket)
        : server_(server),
          hooks_(std::move(hooks)),
          socket_(std::move(socket)),
          address_(listener.address),
          port_(listener.port) {}
    void listen();
    void accept_one();
    void pause(const std::string& why);
    void hand_over(GObjectHandle<GSocket> socket);

    GstRTSPServer* const server_;
    const Hooks hooks_;
    const GObjectHandle<GSocket> socket_;
    const std::string address_;
    const std::uint16_t port_;
    GMainContext* context_ = nullptr;  ///< null: not started, or stopped
    GSource* source_ = nullptr;        ///< null: paused or stopped
    std::deque<Waiting> waiting_;
    LogPace pause_log_;
};

}  // namespace camrig::rtsp
