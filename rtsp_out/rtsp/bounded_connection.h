#pragma once

#include <memory>
#include <string>
#include <utility>

#include <gio/gio.h>

#include "rtsp_out/rtsp/request_bounds.h"

namespace camrig::rtsp {

/// The checks that one connection's input passes before the RTSP library reads it. Server thread.
struct ConnectionGuard {
    ConnectionGuard(const RequestBounds& of_requests, std::shared_ptr<GTlsCertificate> own)
        : bounds(of_requests), certificate(std::move(own)) {}
    RequestBounds bounds;
    std::shared_ptr<GTlsCertificate> certificate;  ///< null: in the clear
    std::string broken;                            ///< the bound that was broken; nothing is read after it
};
using ConnectionGuardRef = std::shared_ptr<ConnectionGuard>;

/// From this call on, what is read through a GTcpConnection made of this socket is decrypted, where there is a
/// certificate, and checked by the guard: the reader sees end of stream where a bound is broken. What is written is not
/// checked.
///
/// gst-rtsp-server (1.22 and 1.26) bounds neither a request's head nor the time it takes to come, and offers no place
/// to look at a request before it is whole: it makes a GTcpConnection of the socket itself and reads that. So for
/// guarded sockets two methods of that class, get_input_stream and get_output_stream, are ours; for all others they are
/// as they were. GIO's own way of putting another class there cannot be used:
/// g_socket_connection_factory_register_type() frees the entry that it has just put in where there was one already
/// (GLib 2.74 to 2.84).
void guard_socket(GSocket* socket, ConnectionGuardRef guard);

/// The guard of this socket; null: it has none.
ConnectionGuardRef guard_of(GSocket* socket);

}  // namespace camrig::rtsp
