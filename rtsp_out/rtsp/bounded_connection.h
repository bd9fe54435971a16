#pragma once

#include <memory>
#include <string>
#include <utility>

#include <gio/gio.h>

#include "rtsp_out/rtsp/request_bounds.h"

namespace camrig {

/// What stands between a client's bytes and the RTSP library, for one connection. Server thread.
struct ConnectionGuard {
    ConnectionGuard(const RequestBounds& of_requests, std::shared_ptr<GTlsCertificate> own)
        : bounds(of_requests), certificate(std::move(own)) {}
    RequestBounds bounds;
    std::shared_ptr<GTlsCertificate> certificate;  ///< null: in the clear
    std::string broken;                            ///< the bound that was broken; nothing is read after it
};
using ConnectionGuardRef = std::shared_ptr<ConnectionGuard>;

/// From here on what is read through connections made of this socket passes its guard first, decrypted where there is a
/// certificate: the reader sees the end of the stream where a bound is broken.
///
/// gst-rtsp-server bounds neither a request's head nor the time it takes to come, and offers no place to look at a
/// request before it is whole. It makes its streams with g_socket_connection_factory_create_connection(), where GIO
/// lets a program put a class of its own (g_socket_connection_factory_register_type()). What is written goes straight
/// to the socket.
void guard_socket(GSocket* socket, ConnectionGuardRef guard);

/// Null: none.
ConnectionGuardRef guard_of(GSocket* socket);

}  // namespace camrig
