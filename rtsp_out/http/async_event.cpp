#include "rtsp_out/http/async_event.h"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace camrig::http {

namespace asio = boost::asio;

void AsyncEvent::set() {
    std::lock_guard lock(mutex_);
    if (!executor_ || std::exchange(is_set_, true)) return;
    asio::post(*executor_, [self = shared_from_this()] {
        std::lock_guard inner(self->mutex_);
        if (self->timer_) self->timer_->cancel();
    });
}

asio::awaitable<Wake> AsyncEvent::wait_for(std::chrono::nanoseconds time) {
    {
        std::lock_guard lock(mutex_);
        if (!timer_) co_return Wake::disconnected;
        if (std::exchange(is_set_, false)) co_return Wake::set;
        timer_->expires_after(time);
    }
    // One set from here on posts its cancel() to this thread, so it comes after the wait has begun.
    const auto [failed] = co_await timer_->async_wait(asio::as_tuple(asio::use_awaitable));
    std::lock_guard lock(mutex_);
    if (!timer_) co_return Wake::disconnected;
    if (std::exchange(is_set_, false)) co_return Wake::set;
    co_return failed ? Wake::set : Wake::timeout;
}

void AsyncEvent::disconnect() {
    std::lock_guard lock(mutex_);
    executor_.reset();
    timer_.reset();
}

}  // namespace camrig::http
