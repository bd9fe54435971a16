#pragma once

#include <array>
#include <chrono>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>

namespace camrig::http {

using SendPieces = std::array<boost::asio::const_buffer, 3>;

/// Writes all bytes to the socket. Fails with boost::beast::error::timeout when the peer accepts no byte for
/// `stalled_after`; a slow peer is no error. The bytes must outlive the call. Server's thread.
boost::asio::awaitable<boost::beast::error_code> send_all(boost::beast::tcp_stream& stream, SendPieces pieces,
                                                          std::chrono::nanoseconds stalled_after);

}  // namespace camrig::http
