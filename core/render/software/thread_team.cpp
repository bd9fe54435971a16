#include "core/render/software/thread_team.h"

#include <utility>

#include <pthread.h>

#include "core/base/result.h"

namespace camrig::render::software {

ThreadTeam::ThreadTeam(int threads) {
    CHECK(threads >= 1);
    for (int worker = 1; worker < threads; ++worker) {
        threads_.emplace_back([this, worker] { serve(worker); });
        ::pthread_setname_np(threads_.back().native_handle(), "camrig-raster");
    }
}

ThreadTeam::~ThreadTeam() {
    {
        const std::lock_guard lock(mutex_);
        stops_ = true;
    }
    asked_.notify_all();
    for (std::thread& thread : threads_) thread.join();
}

void ThreadTeam::run(std::size_t count, Job job) {
    if (threads_.empty() || count < 2) {
        for (std::size_t i = 0; i < count; ++i) job.call(job.context, 0, i);
        return;
    }
    std::unique_lock lock(mutex_);
    job_ = job;
    next_ = 0;
    count_ = count;
    asked_.notify_all();
    work(0, lock);
    done_.wait(lock, [this] { return busy_ == 0; });
    count_ = next_ = 0;
    if (thrown_ != nullptr) std::rethrow_exception(std::exchange(thrown_, nullptr));
}

void ThreadTeam::serve(int worker) {
    std::unique_lock lock(mutex_);
    while (true) {
        asked_.wait(lock, [this] { return stops_ || next_ < count_; });
        if (stops_) return;
        work(worker, lock);
    }
}

void ThreadTeam::work(int worker, std::unique_lock<std::mutex>& lock) {
    ++busy_;
    while (next_ < count_) {
        const std::size_t index = next_++;
        const Job job = job_;
        lock.unlock();
        std::exception_ptr thrown;
        try {
            job.call(job.context, worker, index);
        } catch (...) {
            thrown = std::current_exception();
        }
        lock.lock();
        if (thrown == nullptr) continue;
        next_ = count_;
        if (thrown_ == nullptr) thrown_ = std::move(thrown);
    }
    if (--busy_ == 0) done_.notify_one();
}

}  // namespace camrig::render::software
