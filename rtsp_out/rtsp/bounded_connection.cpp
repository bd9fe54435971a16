#include "rtsp_out/rtsp/bounded_connection.h"

#include <mutex>
#include <string_view>
#include <utility>

#include "core/base/clock.h"

namespace camrig::rtsp {
namespace {

constexpr const char* guard_key = "camrig-guard";
constexpr const char* streams_key = "camrig-bounded-streams";

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

// ---- the connection that is read through it

/// The streams of one guarded connection.
struct BoundedStreams {
    GIOStream* base;  ///< plain or TLS
    GInputStream* input;
};

void free_streams(void* streams) {
    auto* const done = static_cast<BoundedStreams*>(streams);
    g_object_unref(done->input);
    g_object_unref(done->base);
    delete done;
}

BoundedStreams* make_streams(GSocket* socket, ConnectionGuardRef guard) {
    // Not a GTcpConnection: its streams are the socket's own.
    auto* base = G_IO_STREAM(g_object_new(G_TYPE_SOCKET_CONNECTION, "socket", socket, nullptr));
    GIOStream* tls =
        guard->certificate ? g_tls_server_connection_new(base, guard->certificate.get(), nullptr) : nullptr;
    if (tls) {
        g_object_unref(std::exchange(base, tls));
        g_tls_connection_set_require_close_notify(G_TLS_CONNECTION(tls), FALSE);
    }
    CHECK((tls != nullptr) == (guard->certificate != nullptr));  // who could load a certificate can do TLS
    auto* const input = g_object_new(bounded_input_get_type(), "base-stream", g_io_stream_get_input_stream(base),
                                     "close-base-stream", FALSE, nullptr);
    reinterpret_cast<BoundedInput*>(input)->guard = new ConnectionGuardRef(std::move(guard));
    return new BoundedStreams{base, G_INPUT_STREAM(input)};
}

/// Null: the connection's socket has no guard.
BoundedStreams* streams_of(GIOStream* connection) {
    if (auto* const made = g_object_get_data(G_OBJECT(connection), streams_key))
        return static_cast<BoundedStreams*>(made);
    GSocket* socket = g_socket_connection_get_socket(G_SOCKET_CONNECTION(connection));
    auto guard = socket ? guard_of(socket) : nullptr;
    if (!guard) return nullptr;
    BoundedStreams* const streams = make_streams(socket, std::move(guard));
    g_object_set_data_full(G_OBJECT(connection), streams_key, streams, free_streams);
    return streams;
}

/// The methods of GTcpConnection as they were.
decltype(GIOStreamClass::get_input_stream) plain_input;
decltype(GIOStreamClass::get_output_stream) plain_output;

GInputStream* input_of(GIOStream* connection) {
    const BoundedStreams* const streams = streams_of(connection);
    return streams ? streams->input : plain_input(connection);
}

GOutputStream* output_of(GIOStream* connection) {
    const BoundedStreams* const streams = streams_of(connection);
    return streams ? g_io_stream_get_output_stream(streams->base) : plain_output(connection);
}

void take_methods() {
    auto* const methods = G_IO_STREAM_CLASS(g_type_class_ref(G_TYPE_TCP_CONNECTION));  // kept for good
    plain_input = std::exchange(methods->get_input_stream, input_of);
    plain_output = std::exchange(methods->get_output_stream, output_of);
}

}  // namespace

void guard_socket(GSocket* socket, ConnectionGuardRef guard) {
    static std::once_flag once;
    std::call_once(once, take_methods);
    g_object_set_data_full(G_OBJECT(socket), guard_key, new ConnectionGuardRef(std::move(guard)),
                           [](void* kept) { delete static_cast<ConnectionGuardRef*>(kept); });
}

ConnectionGuardRef guard_of(GSocket* socket) {
    auto* const kept = g_object_get_data(G_OBJECT(socket), guard_key);
    return kept ? *static_cast<ConnectionGuardRef*>(kept) : nullptr;
}

}  // namespace camrig::rtsp
