#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace camrig {

/// One thread that runs jobs in the order they came. Any thread may post; a job must not stop its own thread.
class WorkThread {
public:
    explicit WorkThread(std::size_t max_waiting);
    ~WorkThread() { stop(); }
    WorkThread(const WorkThread&) = delete;
    WorkThread& operator=(const WorkThread&) = delete;

    /// False, and the job is left untouched, when `max_waiting` jobs wait or the thread was stopped.
    bool post(std::function<void()>& job);
    /// Ends after the job in progress; waiting ones are destroyed without being run. Twice is fine.
    void stop();

private:
    void run();

    const std::size_t max_waiting_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::function<void()>> jobs_;
    bool stopped_ = false;
    std::thread thread_;
};

}  // namespace camrig
