#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <vector>

#include "core/stream/sink.h"

namespace camrig::stream {

/// A sink that remembers what it got and can be told to be stuck or to fail.
class FakeSink final : public Sink {
public:
    Result<void> open(const StreamInfo& info) override {
        std::lock_guard lock(mutex_);
        ++opened_;
        info_ = info;
        if (open_error_) return std::unexpected(*open_error_);
        return {};
    }
    Result<void> write(const MediaUnit& unit) override {
        std::unique_lock lock(mutex_);
        ++begun_;
        changed_.notify_all();
        changed_.wait(lock, [this] { return !stuck_; });
        if (write_error_) return std::unexpected(*write_error_);
        units_.push_back(unit);
        if (keep_holds_ && unit.latch) holds_.push_back(unit.latch->hold("fake reader"));
        info_.stats->delivered.fetch_add(1);
        changed_.notify_all();
        return {};
    }
    void close() noexcept override {
        std::lock_guard lock(mutex_);
        ++closed_;
        changed_.notify_all();
    }

    void set_stuck(bool stuck) {
        std::lock_guard lock(mutex_);
        stuck_ = stuck;
        changed_.notify_all();
    }
    void fail_writes(std::optional<Error> why) {
        std::lock_guard lock(mutex_);
        write_error_ = std::move(why);
    }
    void fail_open(std::optional<Error> why) {
        std::lock_guard lock(mutex_);
        open_error_ = std::move(why);
    }
    void keep_holds() { keep_holds_ = true; }
    void release_holds() {
        std::vector<DeliveryLatch::Hold> holds;
        {
            std::lock_guard lock(mutex_);
            holds.swap(holds_);
        }
    }
    /// Waits (bounded) until so many units have come; false if they did not.
    bool wait_for_units(std::size_t count) {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, limit, [&] { return units_.size() >= count; });
    }
    /// Waits (bounded) until a write has begun; false if none did.
    bool wait_for_write() {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, limit, [&] { return begun_ > 0; });
    }
    bool wait_for_close() {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, limit, [&] { return closed_ > 0; });
    }
    std::vector<MediaUnit> units() {
        std::lock_guard lock(mutex_);
        return units_;
    }
    int opened() {
        std::lock_guard lock(mutex_);
        return opened_;
    }
    int closed() {
        std::lock_guard lock(mutex_);
        return closed_;
    }
    StreamInfo info() {
        std::lock_guard lock(mutex_);
        return info_;
    }

private:
    static constexpr std::chrono::seconds limit{20};
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<MediaUnit> units_;
    std::vector<DeliveryLatch::Hold> holds_;
    std::optional<Error> write_error_, open_error_;
    StreamInfo info_;
    bool stuck_ = false;
    bool keep_holds_ = false;
    int opened_ = 0;
    int begun_ = 0;  ///< writes
    int closed_ = 0;
};

}  // namespace camrig::stream
