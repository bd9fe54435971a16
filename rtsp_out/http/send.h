#pragma once

#include <array>
#include <chrono>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>

namespace camrig::http {

using SendPieces = std::array<boost::asio::const_buffer, 3>;

/// Hands all bytes to the kernel. Fails with boost::beast::error::timeout when the peer takes no byte for
/// `stalled_after`: slow is allowed, standing still is not. The bytes must outlive the call.
boost::asio::awaitable<boost::beast::error_code> send_all(boost::beast::tcp_stream& stream, SendPieces pieces,
                                                          std::chrono::nanoseconds stalled_after);

}  // namespace camrig::http
