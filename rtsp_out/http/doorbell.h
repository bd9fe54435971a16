#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>

#include "core/base/result.h"

namespace camrig {

enum class Wake : std::uint8_t { rung, timeout, disconnected };

/// Wakes the coroutine of one connection from any thread.
///
/// Whoever has something for the connection (a sink, a fetch, an RPC answer) stores it where the coroutine will look
/// and rings. Rings between two waits add up to one. After disconnect() nothing reaches the io_context any more, so
/// bells may outlive it; that is why others hold the bell and never the connection.
class Doorbell : public std::enable_shared_from_this<Doorbell> {
public:
    static std::shared_ptr<Doorbell> create(const boost::asio::any_io_executor& executor);

    /// Any thread; never blocks.
    void ring();
    /// The server's thread; one wait at a time. Spurious wake-ups are told as `rung`.
    boost::asio::awaitable<Wake> wait_for(std::chrono::nanoseconds time);
    /// The server's thread. Ends a wait in progress.
    void disconnect();

private:
    explicit Doorbell(const boost::asio::any_io_executor& executor) : executor_(executor), timer_(executor) {}

    std::mutex mutex_;
    std::optional<boost::asio::any_io_executor> executor_;  ///< gone after disconnect()
    std::optional<boost::asio::steady_timer> timer_;        ///< gone after disconnect()
    bool rung_ = false;
};

/// A value that another thread delivers once, and that one connection waits for.
template <typename T>
class Later {
public:
    explicit Later(std::shared_ptr<Doorbell> bell) : bell_(std::move(bell)) {}

    /// Any thread. Values after the first are ignored.
    void set(T value) {
        {
            std::lock_guard lock(mutex_);
            if (done_) return;
            done_ = true;
            value_.emplace(std::move(value));
        }
        bell_->ring();
    }
    std::optional<T> take() {
        std::lock_guard lock(mutex_);
        return std::exchange(value_, std::nullopt);
    }

    /// The server's thread. `unavailable` when the time is over or the connection goes away.
    boost::asio::awaitable<Result<T>> wait_for(std::chrono::nanoseconds time) {
        const auto deadline = std::chrono::steady_clock::now() + time;
        for (;;) {
            if (auto value = take()) co_return std::move(*value);
            const auto left = deadline - std::chrono::steady_clock::now();
            if (left <= std::chrono::nanoseconds(0))
                co_return error(ErrorKind::unavailable,
                                "no answer within " +
                                    std::to_string(std::chrono::duration_cast<std::chrono::seconds>(time).count()) +
                                    " s; try again");
            const Wake wake = co_await bell_->wait_for(left);
            if (wake == Wake::disconnected) co_return error(ErrorKind::unavailable, "the connection is closed");
        }
    }

private:
    const std::shared_ptr<Doorbell> bell_;
    std::mutex mutex_;
    bool done_ = false;
    std::optional<T> value_;
};

}  // namespace camrig
