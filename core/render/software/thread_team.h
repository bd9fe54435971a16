#pragma once

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace camrig::render::software {

/// Some threads that do the same for different numbers, together with the one that asks. Allocates nothing per run.
class ThreadTeam {
public:
    /// In all, with the one that asks; 1: no others.
    explicit ThreadTeam(int threads);
    ~ThreadTeam();
    ThreadTeam(const ThreadTeam&) = delete;
    ThreadTeam& operator=(const ThreadTeam&) = delete;

    int size() const { return static_cast<int>(threads_.size()) + 1; }

    /// work(worker, index) once for each index below count, from any worker 0 <= worker < size(); returns when all is
    /// done. One thread at a time may ask. What `work` throws first comes out here, when nobody works any more; what
    /// was not begun by then is left.
    template <typename Work>
    void run(std::size_t count, const Work& work) {
        run(count, {[](const void* context, int worker, std::size_t index) {
                        (*static_cast<const Work*>(context))(worker, index);
                    },
                    &work});
    }

private:
    struct Job {
        void (*call)(const void* context, int worker, std::size_t index) = nullptr;
        const void* context = nullptr;
    };
    void run(std::size_t count, Job job);
    void serve(int worker);
    /// With the lock held: does what is left.
    void work(int worker, std::unique_lock<std::mutex>& lock);

    std::mutex mutex_;
    std::condition_variable asked_, done_;
    Job job_;
    std::size_t next_ = 0, count_ = 0;
    int busy_ = 0;
    std::exception_ptr thrown_;  ///< of this run, first
    bool stops_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace camrig::render::software
