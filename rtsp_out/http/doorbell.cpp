#include "rtsp_out/http/doorbell.h"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace camrig {

namespace asio = boost::asio;

std::shared_ptr<Doorbell> Doorbell::create(const asio::any_io_executor& executor) {
    return std::shared_ptr<Doorbell>(new Doorbell(executor));
}

void Doorbell::ring() {
    std::lock_guard lock(mutex_);
    if (!executor_ || std::exchange(rung_, true)) return;
    asio::post(*executor_, [self = shared_from_this()] {
        std::lock_guard inner(self->mutex_);
        if (self->timer_) self->timer_->cancel();
    });
}

asio::awaitable<Wake> Doorbell::wait_for(std::chrono::nanoseconds time) {
    {
        std::lock_guard lock(mutex_);
        if (!timer_) co_return Wake::disconnected;
        if (std::exchange(rung_, false)) co_return Wake::rung;
        timer_->expires_after(time);
    }
    // A ring from here on posts its cancel() to this thread, so it comes after the wait has begun.
    const auto [failed] = co_await timer_->async_wait(asio::as_tuple(asio::use_awaitable));
    std::lock_guard lock(mutex_);
    if (!timer_) co_return Wake::disconnected;
    if (std::exchange(rung_, false)) co_return Wake::rung;
    co_return failed ? Wake::rung : Wake::timeout;
}

void Doorbell::disconnect() {
    std::lock_guard lock(mutex_);
    executor_.reset();
    timer_.reset();
}

}  // namespace camrig
