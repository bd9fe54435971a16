#pragma once

#include <list>
#include <memory>
#include <optional>
#include <string>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

#include "rtsp_out/http/async_event.h"
#include "rtsp_out/http/handlers.h"
#include "rtsp_out/http/picture_stream.h"
#include "rtsp_out/http/reply.h"
#include "rtsp_out/http/server_state.h"

namespace camrig::http {

/// "127.0.0.1:8080", "[::1]:8080".
std::string describe(const boost::asio::ip::tcp::endpoint& endpoint);

/// One TCP connection: reads requests one after the other, checks access, answers. Server's thread.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
public:
    /// `device`: the name that HttpServer::open_device_port() was given for this port; nullopt: the rig's own port.
    HttpConnection(ServerState& state, boost::asio::ip::tcp::socket socket, boost::asio::ip::tcp::endpoint peer,
                   std::optional<std::string> device);
    ~HttpConnection();
    HttpConnection(const HttpConnection&) = delete;
    HttpConnection& operator=(const HttpConnection&) = delete;

    /// Serves requests until the connection ends. The caller keeps `this` alive.
    boost::asio::awaitable<void> run();
    /// Closes the socket, which ends run(), and stops counting against HttpLimits::connections. Twice is fine.
    void close();
    /// Makes a stream on this connection look again at what it depends on (ServerState::camera_changes).
    void wake() { event_->set(); }
    boost::asio::ip::address peer_address() const { return peer_address_; }

private:
    using Parser = boost::beast::http::request_parser<boost::beast::http::string_body>;
    using Message = Parser::value_type;

    /// One request; false when it was the last.
    boost::asio::awaitable<bool> serve_one();
    Result<std::unique_ptr<PictureStream>> open_stream(const HttpRequest& request);
    /// Sends a stream to its end, or says why there is none.
    boost::asio::awaitable<bool> run_stream(const HttpRequest& request);
    boost::asio::awaitable<bool> send(Reply reply, const HttpRequest& request);
    boost::asio::awaitable<std::optional<Reply>> read_body(Parser& parser, HttpRequest& request);
    /// Fills `request` from the header fields, or says why it is refused.
    std::optional<Reply> examine(const Message& message, HttpRequest& request) const;
    std::optional<Reply> check_message(const Message& message) const;
    /// Whether the request is allowed at all, and whether it may change anything (HttpRequest::may_command).
    std::optional<Reply> check_access(const Message& message, HttpRequest& request) const;
    /// The same on the port of a network camera, where a SOAP message may carry its own credentials (WS-Security).
    std::optional<Reply> check_device_access(const Message& message, HttpRequest& request) const;
    Result<HttpRoute> find_route(const std::string& path) const;
    /// Closes streams whose client has gone while we wait for pictures.
    boost::asio::awaitable<void> watch_peer();
    /// Lets the peer read our last answer: closing with unread input would reset the connection.
    boost::asio::awaitable<void> linger();

    std::size_t body_bytes() const {
        return device_ ? state_.options.limits.device_body_bytes : state_.options.limits.body_bytes;
    }

    /// Adds this connection to ServerState::waiting, and removes it.
    void begin_waiting();
    void end_waiting();
    /// Waits HttpLimits::wrong_token and logs, at most once a second, if the request had wrong credentials.
    boost::asio::awaitable<void> hold_back(const Message& message, const HttpRequest& request);

    ServerState& state_;
    const boost::asio::ip::address peer_address_;
    const std::string peer_;
    const std::uint16_t local_port_;
    const std::optional<std::string> device_;
    boost::beast::tcp_stream stream_;
    boost::beast::flat_buffer buffer_;
    std::optional<std::list<HttpConnection*>::iterator> waiting_;  ///< its place in ServerState::waiting
    bool is_closed_ = false;
    const AsyncEventRef event_;
};

}  // namespace camrig::http
