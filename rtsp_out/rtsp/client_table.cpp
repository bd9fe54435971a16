#include "rtsp_out/rtsp/client_table.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include "core/base/clock.h"
#include "rtsp_out/rtsp/media_feed.h"
#include "rtsp_out/rtsp/rtsp_mount.h"
#include "rtsp_out/rtsp/tcp_reader.h"

namespace camrig::rtsp {
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

std::size_t sessions_of(GstRTSPClient* client) {
    GList* sessions = gst_rtsp_client_session_filter(client, nullptr, nullptr);
    const std::size_t count = g_list_length(sessions);
    g_list_free_full(sessions, g_object_unref);
    return count;
}

/// A status line holds printable ASCII.
std::string one_line(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = ' ';
    return text;
}

}  // namespace

void break_when_closed(GstRTSPClient* client) {
    GSocket* const socket = gst_rtsp_connection_get_write_socket(gst_rtsp_client_get_connection(client));
    const linger at_once{.l_onoff = 1, .l_linger = 0};
    ::setsockopt(g_socket_get_fd(socket), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
}

void close_later(GMainContext* context, GstRTSPClient* client) {
    GSource* source = g_idle_source_new();
    g_source_set_priority(source, G_PRIORITY_HIGH);  // also while others keep the loop busy
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

bool ClientTable::make_room(const std::string& address) {
    thread_.check();
    std::size_t staying = 0, strangers = 0, of_address = 0;
    Clients::value_type *oldest = nullptr, *oldest_of_address = nullptr;
    const auto keep_older = [](Clients::value_type*& kept, Clients::value_type& entry) {
        if (!kept || entry.second.number < kept->second.number) kept = &entry;
    };
    for (auto& entry : clients_) {
        const Client& record = entry.second;
        if (record.leaves) continue;
        ++staying;
        if (!record.is_stranger) continue;
        ++strangers;
        keep_older(oldest, entry);
        if (record.address != address) continue;
        ++of_address;
        keep_older(oldest_of_address, entry);
    }
    Clients::value_type* goes = nullptr;
    if (of_address >= limits_.strangers_per_address)
        goes = oldest_of_address;
    else if (strangers >= limits_.strangers || staying >= limits_.connections)
        goes = oldest;
    else
        return true;
    if (!goes) {
        ++counts_.refused;
        return false;
    }
    ++counts_.displaced;
    close(goes->first, goes->second);
    return true;
}

void ClientTable::shed() {
    Clients::value_type* oldest = nullptr;
    for (auto& entry : clients_) {
        const bool may_go = entry.second.is_stranger && !entry.second.leaves;
        if (may_go && (!oldest || entry.second.number < oldest->second.number)) oldest = &entry;
    }
    if (!oldest) return;
    ++counts_.displaced;
    close(oldest->first, oldest->second);
}

bool ClientTable::must_wait(const std::string& address) const {
    return failed_logins_.must_wait(address, monotonic_now_ns());
}

void ClientTable::close(GstRTSPClient* client, Client& record) {
    record.leaves = true;
    close_later(g_main_context_get_thread_default(), client);
}

void ClientTable::log(const std::string& address, const std::string& what) {
    const auto left_out = log_pace_.due(monotonic_now_ns());
    if (!left_out) return;
    const std::string more = *left_out > 0 ? " (and " + std::to_string(*left_out) + " like it)" : "";
    spdlog::warn("rtsp: {}: {}{}", address, what, more);
}

void ClientTable::close_idle(TimeNs monotonic_ns) {
    thread_.check();
    for (auto& [client, record] : clients_) {
        if (record.leaves) continue;
        const TimeNs began_ns = record.guard->bounds.message_began_ns();
        const bool is_late = began_ns != 0 && monotonic_ns - began_ns > limits_.request_ms * ns_per_ms;
        const bool is_quiet =
            record.is_stranger && monotonic_ns - record.quiet_since_ns > limits_.stranger_quiet_ms * ns_per_ms;
        if (is_late) log(record.address, "closed: its request did not come to an end");
        if (is_late || is_quiet) close(client, record);
    }
}

void ClientTable::add(GstRTSPClient* client) {
    thread_.check();
    GSocket* socket = gst_rtsp_connection_get_write_socket(gst_rtsp_client_get_connection(client));
    auto guard = guard_of(socket);
    CHECK(guard != nullptr);
    tune(socket);
    Client record;
    record.guard = std::move(guard);
    record.address = gst_rtsp_connection_get_ip(gst_rtsp_client_get_connection(client));
    record.quiet_since_ns = monotonic_now_ns();
    record.number = ++last_number_;
    clients_.emplace(client, std::move(record));
    counts_.open = clients_.size();
    ++counts_.total;
    g_signal_connect(client, "closed", G_CALLBACK(on_closed), this);
    const auto ask = +[](GstRTSPClient* asking, GstRTSPContext* context, void* table) {
        return static_cast<ClientTable*>(table)->on_ask(asking, context);
    };
    g_signal_connect(client, "pre-describe-request", G_CALLBACK(ask), this);
    g_signal_connect(client, "pre-setup-request", G_CALLBACK(ask), this);
    g_signal_connect(client, "setup-request", G_CALLBACK(on_setup), this);
    g_signal_connect(client, "play-request", G_CALLBACK(on_play), this);
    for (const char* rest : {"pause-request", "teardown-request"})
        g_signal_connect(client, rest, G_CALLBACK(on_rest), this);
    g_signal_connect(client, "send-message", G_CALLBACK(on_answer), this);
}

/// Pictures go out at once. A peer that takes nothing (stopped, or gone without a word) is closed by the kernel, which
/// frees what waits for it: gst-rtsp-server drops such a client's packets after ten seconds but keeps the connection.
void ClientTable::tune(GSocket* socket) const {
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
    auto good = refusal_(path, found->second.address);
    // A session lives on for RtspLimits::session_timeout_s; nothing else bounds them.
    if (good && context->method == GST_RTSP_SETUP && !context->session &&
        sessions_of(client) >= limits_.sessions_per_connection)
        good = error(ErrorKind::resource_exhausted,
                     "this connection has " + std::to_string(limits_.sessions_per_connection) + " sessions; end one");
    if (!good) {
        found->second.reason = one_line(good.error().message);
        return status_of(good.error().kind);
    }
    found->second.paths.insert(path);
    return GST_RTSP_STS_OK;
}

void ClientTable::on_answer(GstRTSPClient* client, GstRTSPContext* context, GstRTSPMessage* answer, void* table) {
    auto* const self = static_cast<ClientTable*>(table);
    const auto found = self->clients_.find(client);
    if (found == self->clients_.end() || answer->type != GST_RTSP_MESSAGE_RESPONSE) return;
    self->read_answer(client, found->second, *context, answer->type_data.response.code);
    // It would name the first packet this reader gets, but gst-rtsp-server reads it off before the reader is let in,
    // and pictures may go by in between. A GStreamer reader waits for ever for packets that were announced and never
    // come. RFC 2326 12.33 leaves the header to the server; a stream that was joined has no other use for it.
    gst_rtsp_message_remove_header(answer, GST_RTSP_HDR_RTP_INFO, -1);
    if (found->second.reason.empty()) return;
    const std::string reason = std::exchange(found->second.reason, {});
    g_free(answer->type_data.response.reason);
    answer->type_data.response.reason = g_strdup(reason.c_str());
}

/// What an answer says of the one who gets it.
void ClientTable::read_answer(GstRTSPClient* client, Client& record, const GstRTSPContext& context,
                              GstRTSPStatusCode status) {
    const TimeNs now_ns = monotonic_now_ns();
    if (status == GST_RTSP_STS_OK) {
        record.quiet_since_ns = now_ns;
        if (context.token || context.session) record.is_stranger = false;
        return;
    }
    gchar* given = nullptr;
    if (status != GST_RTSP_STS_UNAUTHORIZED || !context.request ||
        gst_rtsp_message_get_header(context.request, GST_RTSP_HDR_AUTHORIZATION, &given, 0) != GST_RTSP_OK)
        return;
    ++counts_.wrong_tokens;
    failed_logins_.add(record.address, now_ns);
    log(record.address, "wrong user or token");
    if (++record.wrong_tokens >= limits_.wrong_tokens && !record.leaves) close(client, record);
}

void ClientTable::on_setup(GstRTSPClient* client, GstRTSPContext* context, void* table) {
    if (!is_tcp(context->trans)) return;
    const auto feed = RtspMount::feed_of(context->media);
    unpack_carriers(context->trans, feed ? feed->nal_codec() : std::nullopt);
    auto& clients = static_cast<ClientTable*>(table)->clients_;
    if (const auto found = clients.find(client); found != clients.end()) {
        found->second.is_sent_to = true;
        found->second.guard->bounds.allow_data();
    }
}

void ClientTable::on_play(GstRTSPClient* client, GstRTSPContext* context, void* table) {
    if (const auto feed = RtspMount::feed_of(context->media)) {
        auto& clients = static_cast<ClientTable*>(table)->clients_;
        if (const auto found = clients.find(client); found != clients.end()) found->second.plays.insert(feed);
        feed->client_plays(client);
        if (is_tcp(gst_rtsp_session_media_get_transport(context->sessmedia, 0)))
            feed->add_tcp_reader(gst_rtsp_connection_get_write_socket(gst_rtsp_client_get_connection(client)));
        const char* peer = gst_rtsp_connection_get_ip(gst_rtsp_client_get_connection(client));
        spdlog::info("rtsp: {} plays {}", peer ? peer : "somebody", feed->path());
    }
}

void ClientTable::on_rest(GstRTSPClient* client, GstRTSPContext* context, void* table) {
    const auto feed =
        RtspMount::feed_of(context->sessmedia ? gst_rtsp_session_media_get_media(context->sessmedia) : nullptr);
    if (!feed) return;
    auto& clients = static_cast<ClientTable*>(table)->clients_;
    if (const auto found = clients.find(client); found != clients.end()) found->second.plays.erase(feed);
    feed->client_rests(client, gst_rtsp_connection_get_write_socket(gst_rtsp_client_get_connection(client)));
}

void ClientTable::on_closed(GstRTSPClient* client, void* table) {
    auto* const self = static_cast<ClientTable*>(table);
    self->thread_.check();
    g_signal_handlers_disconnect_by_data(client, table);
    const auto found = self->clients_.find(client);
    CHECK(found != self->clients_.end());
    if (const std::string& broken = found->second.guard->broken; !broken.empty())
        self->log(found->second.address, "closed: it sent " + broken);
    for (const auto& played : found->second.plays)
        if (const auto feed = played.lock()) feed->client_rests(client, nullptr);
    if (found->second.is_sent_to)
        self->departed_.push_back(
            {GObjectHandle<GstRTSPClient>(GST_RTSP_CLIENT(g_object_ref(client))), monotonic_now_ns()});
    self->clients_.erase(found);
    self->counts_.open = self->clients_.size();
}

void ClientTable::let_go(TimeNs monotonic_ns) {
    thread_.check();
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

}  // namespace camrig::rtsp
