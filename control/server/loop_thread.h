#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include "control/server/loop_post.h"

namespace camrig::control {

/// A server's thread: runs what its coroutines and timers have to do, until there is nothing left. Made before all that
/// uses its loop, and destroyed after it.
class LoopThread {
public:
    /// `name` in messages; the thread is camrig-NAME.
    explicit LoopThread(std::string name) : name_(std::move(name)) {}
    /// stop() was called, or start() never.
    ~LoopThread() = default;
    LoopThread(const LoopThread&) = delete;
    LoopThread& operator=(const LoopThread&) = delete;

    boost::asio::io_context& loop() { return loop_; }
    /// For those who are on other threads. It outlives the thread.
    const std::shared_ptr<LoopPost>& post() const { return post_; }

    void start() {
        thread_ = std::thread([this] {
            while (!run_until_thrown()) continue;
        });
        pthread_setname_np(thread_.native_handle(), ("camrig-" + name_).c_str());
    }
    /// Calls `begin` on the thread, which sees to it that nothing goes on for ever, and waits until all is done. After
    /// that nothing is posted any more. False: it had stopped already. Any thread but its own.
    bool stop(std::function<void()> begin) {
        std::lock_guard lock(stop_mutex_);
        if (!thread_.joinable()) return false;
        (*post_)(std::move(begin));
        thread_.join();
        post_->disconnect();
        return true;
    }

private:
    /// False when something threw (memory ran out): what it was about is lost, everything else goes on.
    bool run_until_thrown() {
        try {
            loop_.run();
            return true;
        } catch (const std::exception& thrown) {
            spdlog::error("{}: {}", name_, thrown.what());
            return false;
        }
    }

    const std::string name_;
    boost::asio::io_context loop_{1};
    std::shared_ptr<LoopPost> post_ = std::make_shared<LoopPost>(loop_.get_executor());
    std::mutex stop_mutex_;
    std::thread thread_;
};

}  // namespace camrig::control
