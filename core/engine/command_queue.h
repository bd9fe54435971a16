#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

#include "core/base/time.h"

namespace camrig {

/// Bounded queue into one consumer, which also sleeps on it until a time. Any thread may put or wake.
template <typename T>
class CommandQueue {
public:
    explicit CommandQueue(std::size_t limit) : limit_(limit) {}

    /// False when the queue is full or closed; the value is untouched then.
    bool put(T& value) {
        {
            std::lock_guard lock(mutex_);
            if (closed_ || queue_.size() >= limit_) return false;
            queue_.push_back(std::move(value));
        }
        wake_.notify_one();
        return true;
    }
    /// Ends the consumer's sleep without a value.
    void wake() {
        {
            std::lock_guard lock(mutex_);
            awake_ = true;
        }
        wake_.notify_one();
    }
    /// Nothing comes in any more.
    void close() {
        {
            std::lock_guard lock(mutex_);
            closed_ = true;
            awake_ = true;
        }
        wake_.notify_one();
    }
    /// Consumer: sleeps until something happens, a value is there or CLOCK_MONOTONIC reaches deadline_ns (absolute, so
    /// waits never add up).
    void wait_until(TimeNs deadline_ns) {
        const std::chrono::steady_clock::time_point deadline{std::chrono::nanoseconds(deadline_ns)};
        std::unique_lock lock(mutex_);
        wake_.wait_until(lock, deadline, [this] { return awake_ || !queue_.empty(); });
        awake_ = false;
    }
    /// Consumer: the oldest value; what it leaves counts against the limit.
    std::optional<T> take() {
        std::lock_guard lock(mutex_);
        if (queue_.empty()) return std::nullopt;
        std::optional<T> value(std::move(queue_.front()));
        queue_.pop_front();
        return value;
    }
    bool closed() const {
        std::lock_guard lock(mutex_);
        return closed_;
    }

private:
    const std::size_t limit_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<T> queue_;
    bool awake_ = false;
    bool closed_ = false;
};

}  // namespace camrig
