#pragma once

#include <cstddef>
#include <functional>
#include <thread>
#include <vector>

#include "core/base/bounded_queue.h"

namespace camrig::stream {

/// Threads that run jobs in the order they came. Any thread may post; a job must not stop its own pool.
class WorkerPool {
public:
    using Job = std::function<void()>;

    WorkerPool(int threads, std::size_t max_waiting);
    /// Runs what waits, then ends the threads.
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    /// False, and the job is left untouched, when `max_waiting` jobs wait or the pool ends.
    bool post(Job&& job) { return jobs_.put(std::move(job)); }
    /// The same for a caller that itself bounds how many wait; only a pool that ends refuses.
    bool post_beyond_limit(Job&& job) { return jobs_.put_beyond_limit(std::move(job)); }
    /// Ends after the jobs in progress; waiting ones are destroyed without being run. Twice is fine.
    void stop();

private:
    void run();

    BoundedQueue<Job> jobs_;
    std::vector<std::thread> threads_;
};

}  // namespace camrig::stream
