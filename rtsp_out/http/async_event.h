#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>

#include "core/base/latest_slot.h"
#include "core/base/result.h"

namespace camrig::http {

enum class Wake : std::uint8_t { set, timeout, disconnected };

/// An event that any thread may set and the coroutine of one connection waits for.
///
/// Whoever has something for the connection (a sink, a fetch, an RPC answer) stores it where the coroutine will look
/// and sets the event, which stays set until the next wait. After disconnect() nothing reaches the io_context any more,
/// so events may outlive it; that is why others hold the event and never the connection.
class AsyncEvent : public std::enable_shared_from_this<AsyncEvent> {
public:
    explicit AsyncEvent(const boost::asio::any_io_executor& executor) : executor_(executor), timer_(executor) {}

    /// Any thread; never blocks.
    void set();
    /// The server's thread; one wait at a time. Spurious wake-ups are told as `set`.
    boost::asio::awaitable<Wake> wait_for(std::chrono::nanoseconds time);
    /// The server's thread. Ends a wait in progress.
    void disconnect();

private:
    std::mutex mutex_;
    std::optional<boost::asio::any_io_executor> executor_;  ///< gone after disconnect()
    std::optional<boost::asio::steady_timer> timer_;        ///< gone after disconnect()
    bool is_set_ = false;
};
using AsyncEventRef = std::shared_ptr<AsyncEvent>;

/// Where another thread puts the answer that a connection waits for.
template <typename T>
std::shared_ptr<LatestSlot<T>> make_answer_slot(const AsyncEventRef& event) {
    return std::make_shared<LatestSlot<T>>([event] { event->set(); });
}

/// The answer, on the server's thread. `unavailable` when the time is over or the connection goes away.
template <typename T>
boost::asio::awaitable<Result<T>> wait_for_answer(std::shared_ptr<LatestSlot<T>> slot, AsyncEventRef event,
                                                  std::chrono::nanoseconds time) {
    const auto deadline = std::chrono::steady_clock::now() + time;
    for (;;) {
        if (auto answer = slot->take()) co_return std::move(*answer);
        const auto left = deadline - std::chrono::steady_clock::now();
        if (left <= std::chrono::nanoseconds(0))
            co_return error(ErrorKind::unavailable,
                            "no answer within " +
                                std::to_string(std::chrono::duration_cast<std::chrono::seconds>(time).count()) +
                                " s; try again");
        const Wake wake = co_await event->wait_for(left);
        if (wake == Wake::disconnected) co_return error(ErrorKind::unavailable, "the connection is closed");
    }
}

}  // namespace camrig::http
