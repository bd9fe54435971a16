#include "rtsp_out/rtsp/listener.h"

#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "core/base/descriptors.h"

namespace camrig::rtsp {
namespace {

std::string take_message(GError*& failed) {
    std::string message = failed ? failed->message : "unknown reason";
    g_clear_error(&failed);
    return message;
}

struct Endpoint {
    std::string address;
    guint16 port = 0;
};

Endpoint peer_of(GSocket* socket) {
    const GObjectHandle<GSocketAddress> address(g_socket_get_remote_address(socket, nullptr));
    if (!address || !G_IS_INET_SOCKET_ADDRESS(address.get())) return {};
    auto* const inet = G_INET_SOCKET_ADDRESS(address.get());
    gchar* text = g_inet_address_to_string(g_inet_socket_address_get_address(inet));
    Endpoint endpoint{text, g_inet_socket_address_get_port(inet)};
    g_free(text);
    return endpoint;
}

}  // namespace

Result<std::unique_ptr<RtspListener>> RtspListener::create(GstRTSPServer* server, TcpListener listener, Hooks hooks) {
    GError* failed = nullptr;
    GObjectHandle<GSocket> socket(g_socket_new_from_fd(listener.fd.get(), &failed));
    if (!socket) return error(ErrorKind::unavailable, "rtsp: " + take_message(failed));
    listener.fd.release();
    g_socket_set_blocking(socket.get(), FALSE);
    g_socket_set_keepalive(socket.get(), TRUE);
    return std::unique_ptr<RtspListener>(new RtspListener(server, listener, std::move(hooks), std::move(socket)));
}

RtspListener::~RtspListener() {
    stop();
}

void RtspListener::start(GMainContext* context) {
    context_ = context;
    listen();
}

void RtspListener::listen() {
    source_ = g_socket_create_source(socket_.get(), G_IO_IN, nullptr);
    const auto on_connection = +[](GSocket*, GIOCondition, void* self) -> gboolean {
        static_cast<RtspListener*>(self)->accept_one();
        return G_SOURCE_CONTINUE;
    };
    g_source_set_callback(source_, reinterpret_cast<GSourceFunc>(reinterpret_cast<void (*)()>(on_connection)), this,
                          nullptr);
    g_source_attach(source_, context_);
}

void RtspListener::stop() {
    context_ = nullptr;
    if (!source_) return;
    g_source_destroy(source_);
    g_source_unref(std::exchange(source_, nullptr));
}

void RtspListener::pause(const std::string& why) {
    if (const auto left_out = pause_log_.due(monotonic_now_ns())) spdlog::warn("rtsp: new connections wait: {}", why);
    hooks_.shed();
    g_source_destroy(source_);
    g_source_unref(std::exchange(source_, nullptr));
}

void RtspListener::accept_one() {
    if (descriptors_are_short()) return pause(too_many_files);
    GError* failed = nullptr;
    GObjectHandle<GSocket> socket(g_socket_accept(socket_.get(), nullptr, &failed));
    if (!socket) {
        // The peer may have gone meanwhile. All else is about this machine, and would come again at once.
        const bool is_over = g_error_matches(failed, G_IO_ERROR, G_IO_ERROR_WOULD_BLOCK) ||
                             g_error_matches(failed, G_IO_ERROR, G_IO_ERROR_CONNECTION_CLOSED);
        const std::string why = take_message(failed);
        if (!is_over) pause(why);
        return;
    }
    const std::string address = peer_of(socket.get()).address;
    if (address.empty() || !hooks_.admit(address)) return;
    if (!hooks_.must_wait(address)) return hand_over(std::move(socket));
    if (waiting_.size() >= max_waiting) waiting_.pop_front();
    waiting_.push_back({std::move(socket), monotonic_now_ns() + wait_ns});
}

void RtspListener::hand_over(GObjectHandle<GSocket> socket) {
    const Endpoint peer = peer_of(socket.get());
    if (peer.address.empty()) return;
    hooks_.prepare(socket.get());
    gst_rtsp_server_transfer_connection(server_, socket.release(), peer.address.c_str(), peer.port, nullptr);
}

void RtspListener::look_after(TimeNs now_ns) {
    while (!waiting_.empty() && waiting_.front().until_ns <= now_ns) {
        GObjectHandle<GSocket> socket = std::move(waiting_.front().socket);
        waiting_.pop_front();
        hand_over(std::move(socket));
    }
    if (!source_ && context_) listen();
}

}  // namespace camrig::rtsp
