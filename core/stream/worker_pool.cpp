#include "core/stream/worker_pool.h"

#include <algorithm>

#include <pthread.h>

namespace camrig::stream {

WorkerPool::WorkerPool(int threads, std::size_t max_waiting) : jobs_(max_waiting) {
    for (int i = 0; i < std::max(threads, 1); ++i) {
        threads_.emplace_back([this] { run(); });
        pthread_setname_np(threads_.back().native_handle(), "camrig-worker");
    }
}

WorkerPool::~WorkerPool() {
    jobs_.close();
    for (auto& thread : threads_)
        if (thread.joinable()) thread.join();
}

void WorkerPool::stop() {
    const auto dropped = jobs_.close_and_take();  // what they hold may answer somebody
    for (auto& thread : threads_)
        if (thread.joinable()) thread.join();
}

void WorkerPool::run() {
    while (auto job = jobs_.wait()) (*job)();
}

}  // namespace camrig::stream
