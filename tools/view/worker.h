#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace camrig::view {

/// A thread that does the same again and again until it is destroyed. The rig is asked on such threads only, so the
/// window never waits for it.
class Worker {
public:
    /// `turn` says how long to rest before the next; wake() ends the rest early.
    explicit Worker(std::function<std::chrono::milliseconds()> turn)
        : thread_([this, turn = std::move(turn)](const std::stop_token& stop) {
              while (!stop.stop_requested()) {
                  const auto rest = turn();
                  std::unique_lock lock(mutex_);
                  changed_.wait_for(lock, stop, rest, [&] { return woken_; });
                  woken_ = false;
              }
          }) {}

    void wake() {
        const std::lock_guard lock(mutex_);
        woken_ = true;
        changed_.notify_all();
    }

private:
    std::mutex mutex_;
    std::condition_variable_any changed_;
    bool woken_ = false;
    std::jthread thread_;  ///< last: it uses what stands above, and ends first
};

}  // namespace camrig::view
