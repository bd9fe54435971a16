#include "rtsp_out/rtsp/bounded_connection.h"

#include <mutex>
#include <string_view>
#include <utility>

#include "core/base/clock.h"

namespace camrig {
namespace {

constexpr const char* guard_key = "camrig-guard";

// ---- the stream that reads along

struct BoundedInput {
    GFilterInputStream parent;
    ConnectionGuardRef* guard;
};
struct BoundedInputClass {
    GFilterInputStreamClass parent;
};
void bounded_input_poll_init(GPollableInputStreamInterface* poll);
G_DEFINE_TYPE_WITH_CODE(BoundedInput, bounded_input, G_TYPE_FILTER_INPUT_STREAM,
                        G_IMPLEMENT_INTERFACE(G_TYPE_POLLABLE_INPUT_STREAM, bounded_input_poll_init))

GPollableInputStream* base_of(void* input) {
    return G_POLLABLE_INPUT_STREAM(g_filter_input_stream_get_base_stream(G_FILTER_INPUT_STREAM(input)));
}

/// What of `size` bytes that were read goes on: all, or the end of the stream.
gssize passed(void* input, const void* bytes, gssize size) {
    ConnectionGuard& guard = **reinterpret_cast<BoundedInput*>(input)->guard;
    if (size <= 0) return size;
    const auto good =
        guard.bounds.take({static_cast<const char*>(bytes), static_cast<std::size_t>(size)}, monotonic_now_ns());
    if (good) return size;
    guard.broken = good.error().message;
    return 0;
}

bool is_broken(void* input) {
    return !(*reinterpret_cast<BoundedInput*>(input)->guard)->broken.empty();
}

gssize read_some(GInputStream* input, void* bytes, gsize size, GCancellable* cancellable, GError** failed) {
    if (is_broken(input)) return 0;
    return passed(input, bytes, g_input_stream_read(G_INPUT_STREAM(base_of(input)), bytes, size, cancellable, failed));
}

gssize read_what_is_there(GPollableInputStream* input, void* bytes, gsize size, GError** failed) {
    if (is_broken(input)) return 0;
    return passed(input, bytes, g_pollable_input_stream_read_nonblocking(base_of(input), bytes, size, nullptr, failed));
}

gboolean is_readable(GPollableInputStream* input) {
    return g_pollable_input_stream_is_readable(base_of(input));
}

GSource* readable_source(GPollableInputStream* input, GCancellable* cancellable) {
    GSource* base = g_pollable_input_stream_create_source(base_of(input), nullptr);
    GSource* source = g_pollable_source_new_full(input, base, cancellable);
    g_source_unref(base);
    return source;
}

void bounded_input_poll_init(GPollableInputStreamInterface* poll) {
    poll->is_readable = is_readable;
    poll->create_source = readable_source;
    poll->read_nonblocking = read_what_is_there;
}

void bounded_input_init(BoundedInput*) {}

void finalize_input(GObject* input) {
    delete reinterpret_cast<BoundedInput*>(input)->guard;
    G_OBJECT_CLASS(bounded_input_parent_class)->finalize(input);
}

void bounded_input_class_init(BoundedInputClass* input) {
    G_OBJECT_CLASS(input)->finalize = finalize_input;
    G_INPUT_STREAM_CLASS(input)->read_fn = read_some;
}

// ---- the connection that reads through it

struct BoundedConnection {
    GTcpConnection parent;
    GIOStream* base;  ///< plain or TLS; null: the socket has no guard
    GInputStream* input;
};
struct BoundedConnectionClass {
    GTcpConnectionClass parent;
};
G_DEFINE_TYPE(BoundedConnection, bounded_connection, G_TYPE_TCP_CONNECTION)

void bounded_connection_init(BoundedConnection*) {}

BoundedConnection* bounded(void* connection) {
    return reinterpret_cast<BoundedConnection*>(connection);
}

GInputStream* input_of(GIOStream* connection) {
    GInputStream* input = bounded(connection)->input;
    return input ? input : G_IO_STREAM_CLASS(bounded_connection_parent_class)->get_input_stream(connection);
}

GOutputStream* output_of(GIOStream* connection) {
    GIOStream* base = bounded(connection)->base;
    return base ? g_io_stream_get_output_stream(base)
                : G_IO_STREAM_CLASS(bounded_connection_parent_class)->get_output_stream(connection);
}

void constructed(GObject* object) {
    G_OBJECT_CLASS(bounded_connection_parent_class)->constructed(object);
    GSocket* socket = g_socket_connection_get_socket(G_SOCKET_CONNECTION(object));
    auto guard = guard_of(socket);
    if (!guard) return;
    BoundedConnection* self = bounded(object);
    self->base = G_IO_STREAM(g_object_new(G_TYPE_TCP_CONNECTION, "socket", socket, nullptr));
    if (guard->certificate) {
        GIOStream* tls = g_tls_server_connection_new(self->base, guard->certificate.get(), nullptr);
        if (!tls) return;  // no TLS in this GLib: RtspServer::create has refused the certificate
        g_object_unref(std::exchange(self->base, tls));
        g_tls_connection_set_require_close_notify(G_TLS_CONNECTION(tls), FALSE);
    }
    auto* input = g_object_new(bounded_input_get_type(), "base-stream", g_io_stream_get_input_stream(self->base),
                               "close-base-stream", FALSE, nullptr);
    reinterpret_cast<BoundedInput*>(input)->guard = new ConnectionGuardRef(std::move(guard));
    self->input = G_INPUT_STREAM(input);
}

void finalize_connection(GObject* connection) {
    BoundedConnection* self = bounded(connection);
    g_clear_object(&self->input);
    g_clear_object(&self->base);
    G_OBJECT_CLASS(bounded_connection_parent_class)->finalize(connection);
}

void bounded_connection_class_init(BoundedConnectionClass* connection) {
    G_OBJECT_CLASS(connection)->constructed = constructed;
    G_OBJECT_CLASS(connection)->finalize = finalize_connection;
    G_IO_STREAM_CLASS(connection)->get_input_stream = input_of;
    G_IO_STREAM_CLASS(connection)->get_output_stream = output_of;
}

}  // namespace

void guard_socket(GSocket* socket, ConnectionGuardRef guard) {
    static std::once_flag once;
    std::call_once(once, [] {
        for (const GSocketFamily family : {G_SOCKET_FAMILY_IPV4, G_SOCKET_FAMILY_IPV6})
            g_socket_connection_factory_register_type(bounded_connection_get_type(), family, G_SOCKET_TYPE_STREAM,
                                                      G_SOCKET_PROTOCOL_TCP);
    });
    g_object_set_data_full(G_OBJECT(socket), guard_key, new ConnectionGuardRef(std::move(guard)),
                           [](void* kept) { delete static_cast<ConnectionGuardRef*>(kept); });
}

ConnectionGuardRef guard_of(GSocket* socket) {
    auto* const kept = g_object_get_data(G_OBJECT(socket), guard_key);
    return kept ? *static_cast<ConnectionGuardRef*>(kept) : nullptr;
}

}  // namespace camrig
