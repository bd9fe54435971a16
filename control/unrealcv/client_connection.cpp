#include "control/unrealcv/client_connection.h"

#include <exception>
#include <utility>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <spdlog/spdlog.h>

#include "core/base/clock.h"

namespace camrig::unrealcv {
namespace asio = boost::asio;
namespace {

constexpr std::size_t read_bytes = 64 * 1024;
constexpr auto no_result = asio::as_tuple(asio::use_awaitable);
/// What a small request costs beside its bytes.
constexpr std::size_t request_overhead = 64;

}  // namespace

ClientConnection::ClientConnection(DoorState& door, const UnrealCvLimits& limits, Socket socket,
                                   std::function<void(ClientConnection*)> on_closed)
    : door_(door),
      limits_(limits),
      socket_(std::move(socket)),
      on_closed_(std::move(on_closed)),
      session_(std::make_shared<Session>(door, socket_.get_executor())),
      room_(socket_.get_executor()),
      ready_(socket_.get_executor()),
      limit_(socket_.get_executor()) {}

void ClientConnection::start(const std::string& greeting) {
    // What throws (memory ran out) ends this connection and no other.
    const auto ended = [self = shared_from_this()](std::exception_ptr thrown) {
        if (thrown) self->close();
    };
    asio::co_spawn(socket_.get_executor(), [self = shared_from_this()] { return self->read_loop(); }, ended);
    asio::co_spawn(
        socket_.get_executor(), [self = shared_from_this(), greeting] { return self->serve_loop(greeting); }, ended);
}

asio::awaitable<void> ClientConnection::read_loop() {
    const auto self = shared_from_this();
    std::array<char, read_bytes> chunk;
    while (!is_closed_) {
        const auto [failed, size] = co_await socket_.async_read_some(asio::buffer(chunk), no_result);
        if (failed) break;
        frames_.append({chunk.data(), size});
        while (auto payload = frames_.next()) {
            waiting_bytes_ += payload->size() + request_overhead;
            waiting_.push_back(std::move(*payload));
        }
        ready_.set();
        if (!frames_.problem().empty()) co_return break_off(frames_.problem());
        while (!is_closed_ && waiting_bytes_ > limits_.waiting_bytes) co_await room_.wait();
    }
    is_at_end_ = true;
    ready_.set();
}

asio::awaitable<void> ClientConnection::serve_loop(std::string greeting) {
    const auto self = shared_from_this();
    const std::string greeting_head = frame_head(greeting.size());
    bool is_open = co_await write(greeting_head, greeting);
    while (is_open && !is_closed_) {
        if (waiting_.empty()) {
            session_->end_batch();
            if (is_at_end_) break;
            co_await ready_.wait();
            continue;
        }
        const std::string payload = std::move(waiting_.front());
        waiting_.pop_front();
        waiting_bytes_ -= payload.size() + request_overhead;
        room_.set();
        const auto request = parse_request(payload);
        if (!request) {
            break_off("a request is no ID:COMMAND");
            break;
        }
        const Answer answer = co_await session_->answer(request->command);
        if (is_closed_) break;
        std::string head(request->id);
        head += ':';
        if (!answer) head += "error ";
        std::string_view body = answer ? answer->bytes() : answer.error();
        if (answer && body.empty()) body = "ok";
        head.insert(0, frame_head(head.size() + body.size()));
        is_open = co_await write(head, body);
        session_->sent();
    }
    close();
}

asio::awaitable<bool> ClientConnection::write(std::string_view head, std::string_view body) {
    std::array<asio::const_buffer, 2> parts{asio::buffer(head.data(), head.size()),
                                            asio::buffer(body.data(), body.size())};
    while (parts[0].size() + parts[1].size() > 0) {
        close_after(limits_.stalled_after);
        const auto [failed, size] = co_await socket_.async_write_some(parts, no_result);
        limit_.expires_at(asio::steady_timer::time_point::max());
        if (failed || is_closed_) co_return false;
        const std::size_t of_head = std::min(size, parts[0].size());
        parts[0] += of_head;
        parts[1] += size - of_head;
    }
    co_return true;
}

void ClientConnection::close_after(UnrealCvLimits::Duration time) {
    limit_.expires_after(time);
    limit_.async_wait([weak = weak_from_this()](boost::system::error_code cancelled) {
        const auto self = weak.lock();
        // A wait that had expired just before it was moved on must not close.
        if (!cancelled && self && self->limit_.expiry() <= asio::steady_timer::clock_type::now()) self->close();
    });
}

void ClientConnection::break_off(const std::string& why) {
    if (const auto left_out = door_.closing_log.due(monotonic_now_ns()))
        spdlog::warn("unrealcv: a connection is closed: {} ({} more were closed before it)", why, *left_out);
    close();
}

void ClientConnection::close() {
    if (std::exchange(is_closed_, true)) return;
    boost::system::error_code ignored;
    socket_.close(ignored);
    session_->close();
    room_.set();
    ready_.set();
    limit_.cancel();
    on_closed_(this);
}

}  // namespace camrig::unrealcv
