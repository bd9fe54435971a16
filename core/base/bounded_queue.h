#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include "core/base/time.h"

namespace camrig {

/// A bounded queue of values, oldest first; any thread may put. Threads hand over by this, or by LatestSlot where only
/// the newest value counts.
///
/// Readers sleep in wait() or wait_until(). One that sleeps elsewhere, in an event loop or in another queue, gives a
/// `wake`: it is called for each value that comes, under the queue's lock, so never after close(); it must not block.
template <typename T>
class BoundedQueue {
public:
    explicit BoundedQueue(std::size_t limit, std::function<void()> wake = {})
        : limit_(limit), wake_reader_(std::move(wake)) {}

    /// False when the queue is full or closed; the value is untouched then.
    bool put(T&& value) { return put_below(limit_, std::move(value)); }
    /// The same for values whose number the sender bounds: only a closed queue refuses them.
    bool put_beyond_limit(T&& value) { return put_below(std::numeric_limits<std::size_t>::max(), std::move(value)); }
    /// Ends the one reader's wait_until() without a value.
    void wake() {
        {
            std::lock_guard lock(mutex_);
            is_awake_ = true;
        }
        changed_.notify_one();
    }
    /// Nothing comes in any more; what is there can be taken.
    void close() {
        {
            std::lock_guard lock(mutex_);
            is_closed_ = true;
        }
        changed_.notify_all();
    }
    /// The same, and gives what was there.
    std::deque<T> close_and_take() {
        std::deque<T> left;
        {
            std::lock_guard lock(mutex_);
            is_closed_ = true;
            left.swap(queue_);
        }
        changed_.notify_all();
        return left;
    }

    /// The oldest value; what it leaves counts against the limit.
    std::optional<T> take() {
        std::lock_guard lock(mutex_);
        return take_first();
    }
    std::deque<T> take_all() {
        std::lock_guard lock(mutex_);
        return std::exchange(queue_, {});
    }
    /// Sleeps until there is a value, and takes it; nothing once the queue is closed and empty.
    std::optional<T> wait() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return is_closed_ || !queue_.empty(); });
        return take_first();
    }
    /// Sleeps until there is a value, wake() was called, or CLOCK_MONOTONIC reaches deadline_ns (absolute, so waits
    /// never add up).
    void wait_until(TimeNs deadline_ns) {
        const std::chrono::steady_clock::time_point deadline{std::chrono::nanoseconds(deadline_ns)};
        std::unique_lock lock(mutex_);
        changed_.wait_until(lock, deadline, [this] { return is_awake_ || is_closed_ || !queue_.empty(); });
        is_awake_ = false;
    }
    bool is_empty() const {
        std::lock_guard lock(mutex_);
        return queue_.empty();
    }
    bool is_closed() const {
        std::lock_guard lock(mutex_);
        return is_closed_;
    }

private:
    bool put_below(std::size_t limit, T&& value) {
        {
            std::lock_guard lock(mutex_);
            if (is_closed_ || queue_.size() >= limit) return false;
            queue_.push_back(std::move(value));
            if (wake_reader_) wake_reader_();
        }
        changed_.notify_one();
        return true;
    }
    std::optional<T> take_first() {
        if (queue_.empty()) return std::nullopt;
        std::optional<T> value(std::move(queue_.front()));
        queue_.pop_front();
        return value;
    }

    const std::size_t limit_;
    const std::function<void()> wake_reader_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<T> queue_;
    bool is_awake_ = false;
    bool is_closed_ = false;
};

}  // namespace camrig
