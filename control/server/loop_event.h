#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace camrig::control {

/// Wakes coroutines of the thread that it lives on. Nothing is handed over by it: waiters look at the state they wait
/// for, and wait again while it is not so; set() while nobody waits is lost. Other threads come by a LoopPost.
class LoopEvent {
public:
    explicit LoopEvent(const boost::asio::any_io_executor& executor) : timer_(executor) {}

    void set() { timer_.cancel(); }
    boost::asio::awaitable<void> wait() {
        timer_.expires_at(boost::asio::steady_timer::time_point::max());
        co_await timer_.async_wait(boost::asio::as_tuple(boost::asio::use_awaitable));
    }

private:
    boost::asio::steady_timer timer_;  ///< never expires; cancelled by set()
};

}  // namespace camrig::control
