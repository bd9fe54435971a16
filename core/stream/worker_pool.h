#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace camrig {

/// A fixed number of threads that run jobs in the order they came. Any thread may post.
///
/// The queue needs no bound of its own: each Output has at most one job in it, and each one-off request is bounded by
/// its caller.
class WorkerPool {
public:
    explicit WorkerPool(int threads);
    /// Runs what is queued, then joins.
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    void post(std::function<void()> job);

private:
    void run();

    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::function<void()>> jobs_;
    bool stopping_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace camrig
