#include "control/server/connection.h"

#include <algorithm>
#include <array>
#include <exception>
#include <utility>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <poll.h>

#include "control/rpc/json_rpc.h"
#include "control/rpc/rpc_server.h"
#include "core/base/token.h"

namespace camrig::control {
namespace asio = boost::asio;
namespace {

constexpr std::size_t read_bytes = 64 * 1024;
constexpr std::size_t write_bytes = 256 * 1024;
constexpr auto no_result = asio::as_tuple(asio::use_awaitable);

/// A web page can make a browser send a request of its own choice to any port; its first line tells.
bool is_http(std::string_view line) {
    return line.ends_with(" HTTP/1.1") || line.ends_with(" HTTP/1.0");
}

}  // namespace

Connection::Connection(ConnectionShared& shared, Socket socket, Access access)
    : shared_(shared),
      socket_(std::move(socket)),
      lines_(access.must_show_token ? shared.limits.unauthorized_line_bytes : shared.limits.line_bytes),
      budget_(ByteBudget::create(shared.limits.queued_reply_bytes,
                                 "this connection has " + std::to_string(shared.limits.queued_reply_bytes >> 20) +
                                     " MiB of answers under way; read those that are due, then ask again",
                                 shared.rpc.budget())),
      transport_(access.transport),
      authority_(access.authority),
      peer_(std::move(access.peer)),
      is_authorized_(!access.must_show_token),
      room_(socket_.get_executor()),
      ready_(socket_.get_executor()),
      limit_(socket_.get_executor()),
      pause_(socket_.get_executor()) {}

void Connection::start() {
    thread_.check();
    if (!is_authorized_) close_after(shared_.limits.authorize_time);
    // What throws (memory ran out) ends this connection and no other.
    const auto ended = [self = shared_from_this()](std::exception_ptr thrown) {
        if (thrown) self->close();
    };
    asio::co_spawn(socket_.get_executor(), [self = shared_from_this()] { return self->read_loop(); }, ended);
    asio::co_spawn(socket_.get_executor(), [self = shared_from_this()] { return self->write_loop(); }, ended);
}

asio::awaitable<void> Connection::read_loop() {
    const auto self = shared_from_this();
    std::array<char, read_bytes> chunk;
    while (!is_finishing_) {
        while (co_await room()) {
            const auto line = lines_.next_line();
            if (!line) break;
            if (!take(*line)) co_return finish();
        }
        if (is_finishing_ || is_closed_) break;
        if (lines_.too_long()) {
            refuse(rpc_code::invalid_request, ErrorKind::resource_exhausted,
                   "a message has at most " +
                       std::to_string(is_authorized_ ? shared_.limits.line_bytes
                                                     : shared_.limits.unauthorized_line_bytes) +
                       " bytes; this connection ends");
            break;
        }
        const auto [failed, size] = co_await socket_.async_read_some(asio::buffer(chunk), no_result);
        if (failed == asio::error::eof) {
            if (!lines_.rest().empty() && co_await room()) take(lines_.rest());
            break;
        }
        if (failed) co_return close();
        lines_.append({chunk.data(), size});
    }
    finish();
}

asio::awaitable<bool> Connection::room() {
    while (!is_closed_ && !is_finishing_ &&
           (is_reading_files_ || slots_.size() >= shared_.limits.in_flight ||
            budget_->used() >= shared_.limits.unsent_reply_bytes)) {
        co_await room_.wait();
    }
    co_return !is_closed_ && !is_finishing_;
}

bool Connection::take(std::string_view line) {
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) return true;
    if (is_http(line)) {
        refuse(rpc_code::parse_error, ErrorKind::invalid_argument,
               "this is the control socket, not HTTP; POST /rpc on the HTTP port takes the same messages");
        return false;
    }
    if (!is_authorized_) return take_first(line);
    auto slot = slots_.emplace_back(std::make_shared<Slot>());
    const auto done = [post = shared_.post, weak = weak_from_this(), slot](RpcAnswer reply) {
        (*post)([weak, slot, reply = std::move(reply)]() mutable {
            if (const auto self = weak.lock()) self->answer(slot, std::move(reply));
        });
    };
    const auto started = [post = shared_.post, weak = weak_from_this()] {
        (*post)([weak] {
            if (const auto self = weak.lock()) self->go_on();
        });
    };
    is_reading_files_ = !shared_.rpc.handle(line, done, authority_, budget_, true, started);
    return true;
}

bool Connection::take_first(std::string_view line) {
    const RpcMessage message = parse_rpc(line);
    const auto* request = std::get_if<RpcRequest>(&message.items.front());
    const bool is_auth = !message.is_batch && request && request->method == "auth" &&
                         request->params.contains("token") && request->params["token"].is_string();
    if (!is_auth) {
        refuse(rpc_code::application, ErrorKind::unauthorized,
               R"(a token is needed; begin with {"jsonrpc":"2.0","id":0,"method":"auth","params":{"token":"..."}}: )"
               "the line in the rig's --token-file, or in its key file, which camrig call server.info names");
        return false;
    }
    if (!equal_tokens(request->params["token"].get<std::string>(), shared_.token)) {
        shared_.on_wrong_token(peer_);
        refuse(rpc_code::application, ErrorKind::unauthorized,
               "wrong token; it is the line in the rig's --token-file, or in its key file", shared_.limits.wrong_token);
        return false;
    }
    is_authorized_ = true;
    last_used_ = std::chrono::steady_clock::now();
    if (!shared_.on_authorized(this)) {
        refuse(rpc_code::application, ErrorKind::resource_exhausted,
               "there are " + std::to_string(shared_.limits.connections) + " connections in use already; close one");
        return false;
    }
    limit_.cancel();
    lines_.set_max_line(shared_.limits.line_bytes);
    return take(line);  // and is answered like every other request
}

void Connection::refuse(int code, ErrorKind kind, std::string message, ControlLimits::Duration after) {
    reads_off_ = true;
    const auto slot = slots_.emplace_back(std::make_shared<Slot>());
    RpcAnswer reply;
    reply.append(rpc_error({code, {kind, std::move(message)}, nullptr}));
    pause_.expires_after(after);
    pause_.async_wait([slot, weak = weak_from_this(), reply = std::move(reply)](auto) mutable {
        if (const auto self = weak.lock()) self->answer(slot, std::move(reply));
    });
}

void Connection::go_on() {
    thread_.check();
    is_reading_files_ = false;
    room_.set();
}

void Connection::answer(const std::shared_ptr<Slot>& slot, RpcAnswer reply) {
    thread_.check();
    if (is_closed_) return;
    if (!reply.pieces.empty()) reply.append("\n");
    if (!reply.after_line.empty()) reply.pieces.push_back(std::move(reply.after_line));
    slot->reply = std::move(reply);
    slot->is_ready = true;
    ready_.set();
}

asio::awaitable<void> Connection::write_loop() {
    const auto self = shared_from_this();
    for (;;) {
        while (!is_closed_ && (slots_.empty() ? !is_finishing_ : !slots_.front()->is_ready)) co_await ready_.wait();
        if (is_closed_) co_return;
        if (slots_.empty()) break;
        for (const auto slot = slots_.front(); std::string & piece : slot->reply.pieces) {
            if (!co_await write(piece)) co_return close();
            piece = {};
        }
        slots_.front()->reply = {};  // whoever answered may hold the slot a moment longer
        slots_.pop_front();
        last_used_ = std::chrono::steady_clock::now();
        room_.set();
    }
    if (reads_off_) co_await read_off();
    close();
}

asio::awaitable<bool> Connection::write(std::string_view text) {
    while (!text.empty()) {
        close_after(shared_.limits.stalled_after);
        const auto [failed, size] =
            co_await socket_.async_write_some(asio::buffer(text.data(), std::min(text.size(), write_bytes)), no_result);
        limit_.expires_at(asio::steady_timer::time_point::max());
        if (failed || is_closed_) co_return false;
        text.remove_prefix(size);
    }
    co_return true;
}

asio::awaitable<void> Connection::read_off() {
    boost::system::error_code ignored;
    socket_.shutdown(Socket::shutdown_send, ignored);
    close_after(shared_.limits.linger);
    std::array<char, read_bytes> chunk;
    for (std::size_t total = 0; !is_closed_ && total < shared_.limits.linger_bytes;) {
        const auto [failed, size] = co_await socket_.async_read_some(asio::buffer(chunk), no_result);
        if (failed) break;
        total += size;
    }
}

void Connection::close_after(ControlLimits::Duration time) {
    limit_.expires_after(time);
    limit_.async_wait([weak = weak_from_this()](boost::system::error_code cancelled) {
        const auto self = weak.lock();
        // A wait that had expired just before it was moved on must not close.
        if (!cancelled && self && self->limit_.expiry() <= asio::steady_timer::clock_type::now()) self->close();
    });
}

bool Connection::is_ended_by_peer() {
    pollfd asked{socket_.native_handle(), POLLRDHUP, 0};
    return ::poll(&asked, 1, 0) > 0;
}

void Connection::finish() {
    thread_.check();
    is_finishing_ = true;
    room_.set();
    ready_.set();
    // A reader that waits for the peer is waiting for nothing now; the writer goes on.
    boost::system::error_code ignored;
    if (!is_closed_ && !reads_off_) socket_.shutdown(Socket::shutdown_receive, ignored);
}

void Connection::close() {
    thread_.check();
    if (std::exchange(is_closed_, true)) return;
    boost::system::error_code ignored;
    socket_.close(ignored);
    room_.set();
    ready_.set();
    limit_.cancel();
    pause_.cancel();
    shared_.on_closed(this);
}

}  // namespace camrig::control
