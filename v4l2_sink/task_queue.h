#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include <sys/eventfd.h>

#include "core/base/bounded_queue.h"
#include "core/base/result.h"
#include "core/base/unique_fd.h"

namespace camrig::device {

/// Tasks that other threads post to a thread that waits in poll(): fd() is readable while any wait. Any thread may
/// post.
///
/// A task that clients can cause as often as they like is posted by name and replaces the one of that name that waits:
/// so the queue is bounded by the number of names.
class TaskQueue {
public:
    using Task = std::function<void()>;
    /// Of tasks without a name. A device or a session has a few at a time, so reaching this is a bug (CHECK).
    static constexpr std::size_t max_tasks = 100'000;

    int fd() const { return event_.get(); }
    void post(Task task) { CHECK(tasks_.put(std::move(task))); }
    /// Replaces the task of this name, if one waits. Named tasks run in the order of their names.
    void post(std::string name, Task task) {
        {
            std::lock_guard lock(mutex_);
            const bool is_first = named_.empty();
            named_.insert_or_assign(std::move(name), std::move(task));
            if (!is_first) return;  // run_named() is on its way
        }
        post([this] { run_named(); });
    }
    /// Runs all tasks that wait.
    void run() {
        eventfd_t ignored;
        ::eventfd_read(event_.get(), &ignored);
        for (const Task& task : tasks_.take_all()) task();
    }

private:
    void run_named() {
        std::map<std::string, Task> tasks;
        {
            std::lock_guard lock(mutex_);
            tasks.swap(named_);
        }
        for (const auto& [name, task] : tasks) task();
    }

    const UniqueFd event_{::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
    BoundedQueue<Task> tasks_{max_tasks, [this] { ::eventfd_write(event_.get(), 1); }};
    std::mutex mutex_;
    std::map<std::string, Task> named_;  ///< guarded by mutex_
};

}  // namespace camrig::device
