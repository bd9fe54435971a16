#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/post.hpp>

namespace camrig::control {

/// Runs functions on the server's thread, from any thread, for as long as the server is there. Replies share it: one
/// that comes after the server's end is dropped.
class LoopPost {
public:
    explicit LoopPost(boost::asio::any_io_executor executor) : executor_(std::move(executor)) {}

    template <typename Function>
    void operator()(Function&& function) {
        std::lock_guard lock(mutex_);
        if (executor_) boost::asio::post(*executor_, std::forward<Function>(function));
    }
    /// After this nothing is posted any more.
    void disconnect() {
        std::lock_guard lock(mutex_);
        executor_.reset();
    }

private:
    std::mutex mutex_;
    std::optional<boost::asio::any_io_executor> executor_;
};

}  // namespace camrig::control
