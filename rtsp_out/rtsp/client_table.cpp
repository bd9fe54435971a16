#include "rtsp_out/rtsp/client_table.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include "core/base/clock.h"
#include "rtsp_out/rtsp/rtsp_mount.h"
#include "rtsp_out/rtsp/tcp_followers.h"

namespace camrig {
namespace {

GstRTSPStatusCode status_of(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::not_found:
            return GST_RTSP_STS_NOT_FOUND;
        case ErrorKind::unsupported:
            return GST_RTSP_STS_UNSUPPORTED_MEDIA_TYPE;
        default:
            return GST_RTSP_STS_SERVICE_UNAVAILABLE;
    }
}

/// How long a client that was sent pictures outlives its connection.
constexpr TimeNs afterlife_ns = 2 * ns_per_s;

bool is_tcp(GstRTSPStreamTransport* transport) {
    return transport && gst_rtsp_stream_transport_get_transport(transport)->lower_transport == GST_RTSP_LOWER_TRANS_TCP;
}

/// A status line holds printable ASCII.
std::string one_line(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = ' ';
    return text;
}

}  // namespace

std::string mount_path_of(std::string_view path) {
    if (const auto stream = path.find("/stream="); stream != std::string_view::npos) path = path.substr(0, stream);
    while (path.size() > 1 && path.ends_with('/')) path.remove_suffix(1);
    return std::string(path);
}

void close_later(GMainContext* context, GstRTSPClient* client) {
    GSource* source = g_idle_source_new();
    const auto close = [](void* closing) -> gboolean {
        gst_rtsp_client_close(GST_RTSP_CLIENT(closing));
        return G_SOURCE_REMOVE;
    };
    g_source_set_callback(source, close, g_object_ref(client), g_object_unref);
    g_source_attach(source, context);
    g_source_unref(source);
}

ClientTable::~ClientTable() {
    for (auto& [client, record] : clients_) g_signal_handlers_disconnect_by_data(client, this);
}

void ClientTable::add(GstRTSPClient* client) {
    ++total_;
    if (clients_.size() >= limits_.connections) {
        ++over_limit_;
        close_later(g_main_context_get_thread_default(), client);
        return;
    }
    tune(client);
    clients_.emplace(client, Client{});
    open_ = clients_.size();
    g_signal_connect(client, "closed", G_CALLBACK(on_closed), this);
    const auto ask = +[](GstRTSPClient* asking, GstRTSPContext* context, void* table) {
        return static_cast<ClientTable*>(table)->on_ask(asking, context);
    };
    g_signal_connect(client, "pre-describe-request", G_CALLBACK(ask), this);
    g_signal_connect(client, "pre-setup-request", G_CALLBACK(ask), this);
    g_signal_connect(client, "setup-request", G_CALLBACK(on_setup), this);
    g_signal_connect(client, "pre-play-request", G_CALLBACK(on_pre_play), this);
    g_signal_connect(client, "play-request", G_CALLBACK(on_play), this);
    g_signal_connect(client, "send-message", G_CALLBACK(on_answer), this);
}

/// Pictures go out at once. A peer that takes nothing (stopped, or gone without a word) is closed by the kernel, which
/// frees what waits for it: gst-rtsp-server drops such a client's packets after ten seconds but keeps the connection.
void ClientTable::tune(GstRTSPClient* client) const {
    GstRTSPConnection* connection = gst_rtsp_client_get_connection(client);
    GSocket* socket = connection ? gst_rtsp_connection_get_write_socket(connection) : nullptr;
    if (!socket) return;
    const int fd = g_socket_get_fd(socket);
    const int on = 1;
    ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    ::setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &limits_.send_buffer_bytes, sizeof limits_.send_buffer_bytes);
    const auto stalled_ms = static_cast<unsigned>(limits_.stalled_after_ms);
    ::setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &stalled_ms, sizeof stalled_ms);
}

GstRTSPStatusCode ClientTable::on_ask(GstRTSPClient* client, const GstRTSPContext* context) {
    const auto found = clients_.find(client);
    if (found == clients_.end() || !context->uri || !context->uri->abspath) return GST_RTSP_STS_OK;
    const std::string path = mount_path_of(context->uri->abspath);
    if (const auto good = refusal_(path); !good) {
        found->second.reason = one_line(good.error().message);
        return status_of(good.error().kind);
    }
    found->second.paths.insert(path);
    return GST_RTSP_STS_OK;
}

void ClientTable::on_answer(GstRTSPClient* client, GstRTSPContext*, GstRTSPMessage* answer, void* table) {
    auto* const self = static_cast<ClientTable*>(table);
    const auto found = self->clients_.find(client);
    if (found == self->clients_.end() || found->second.reason.empty()) return;
    const std::string reason = std::exchange(found->second.reason, {});
    if (answer->type != GST_RTSP_MESSAGE_RESPONSE) return;
    g_free(answer->type_data.response.reason);
    answer->type_data.response.reason = g_strdup(reason.c_str());
}

void ClientTable::on_setup(GstRTSPClient* client, GstRTSPContext* context, void* table) {
    if (!is_tcp(context->trans)) return;
    swallow_followers(context->trans);
    auto& clients = static_cast<ClientTable*>(table)->clients_;
    if (const auto found = clients.find(client); found != clients.end()) found->second.is_sent_to = true;
}

GstRTSPStatusCode ClientTable::on_pre_play(GstRTSPClient*, GstRTSPContext* context, void*) {
    if (const auto feed = RtspMount::feed_of(context->media)) feed->client_joins();
    return GST_RTSP_STS_OK;
}

void ClientTable::on_play(GstRTSPClient* client, GstRTSPContext* context, void*) {
    if (const auto feed = RtspMount::feed_of(context->media)) {
        feed->client_plays();
        if (is_tcp(gst_rtsp_session_media_get_transport(context->sessmedia, 0)))
            feed->add_tcp_reader(gst_rtsp_connection_get_write_socket(gst_rtsp_client_get_connection(client)));
        const char* peer = gst_rtsp_connection_get_ip(gst_rtsp_client_get_connection(client));
        spdlog::info("rtsp: {} plays {}", peer ? peer : "somebody", feed->path());
    }
}

void ClientTable::on_closed(GstRTSPClient* client, void* table) {
    auto* const self = static_cast<ClientTable*>(table);
    g_signal_handlers_disconnect_by_data(client, table);
    const auto found = self->clients_.find(client);
    CHECK(found != self->clients_.end());
    if (found->second.is_sent_to)
        self->departed_.push_back(
            {GObjectHandle<GstRTSPClient>(GST_RTSP_CLIENT(g_object_ref(client))), monotonic_now_ns()});
    self->clients_.erase(found);
    self->open_ = self->clients_.size();
}

void ClientTable::let_go(TimeNs monotonic_ns) {
    for (const Departed& one : departed_) gst_rtsp_client_close(one.client.get());  // its sockets at once
    const auto is_over = [&] {
        return departed_.size() > limits_.connections || monotonic_ns - departed_.front().since_ns >= afterlife_ns;
    };
    while (!departed_.empty() && is_over()) departed_.pop_front();
}

std::vector<GObjectHandle<GstRTSPClient>> ClientTable::clients_of(const std::string& path) const {
    std::vector<GObjectHandle<GstRTSPClient>> found;
    for (const auto& [client, record] : clients_)
        if (record.paths.contains(path)) found.emplace_back(GST_RTSP_CLIENT(g_object_ref(client)));
    return found;
}

std::vector<GObjectHandle<GstRTSPClient>> ClientTable::all() const {
    std::vector<GObjectHandle<GstRTSPClient>> found;
    for (const auto& [client, record] : clients_) found.emplace_back(GST_RTSP_CLIENT(g_object_ref(client)));
    return found;
}

}  // namespace camrig
