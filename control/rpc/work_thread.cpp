#include "control/rpc/work_thread.h"

#include <utility>

namespace camrig {

WorkThread::WorkThread(std::size_t max_waiting) : max_waiting_(max_waiting), thread_([this] { run(); }) {}

bool WorkThread::post(std::function<void()>& job) {
    {
        std::lock_guard lock(mutex_);
        if (stopped_ || jobs_.size() >= max_waiting_) return false;
        jobs_.push_back(std::move(job));
    }
    wake_.notify_one();
    return true;
}

void WorkThread::stop() {
    std::deque<std::function<void()>> dropped;  // destroyed outside the lock: what they hold may answer somebody
    {
        std::lock_guard lock(mutex_);
        stopped_ = true;
        dropped.swap(jobs_);
    }
    wake_.notify_one();
    if (thread_.joinable()) thread_.join();
}

void WorkThread::run() {
    for (;;) {
        std::function<void()> job;
        {
            std::unique_lock lock(mutex_);
            wake_.wait(lock, [this] { return stopped_ || !jobs_.empty(); });
            if (stopped_) return;
            job = std::move(jobs_.front());
            jobs_.pop_front();
        }
        job();
    }
}

}  // namespace camrig
