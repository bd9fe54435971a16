#pragma once

#include <functional>
#include <utility>

#include <sys/eventfd.h>

#include "core/base/bounded_queue.h"
#include "core/base/result.h"
#include "core/base/unique_fd.h"

namespace camrig {

/// Work from other threads for one that polls: fd() is readable while there is some. post() from any thread.
class TaskQueue {
public:
    using Task = std::function<void()>;
    /// Devices and sessions have few tasks each under way; so many are a bug.
    static constexpr std::size_t max_tasks = 1'000'000;

    int fd() const { return event_.get(); }
    void post(Task task) { CHECK(tasks_.put(std::move(task))); }
    /// Runs what is there.
    void run() {
        eventfd_t ignored;
        ::eventfd_read(event_.get(), &ignored);
        for (const Task& task : tasks_.take_all()) task();
    }

private:
    const UniqueFd event_{::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
    BoundedQueue<Task> tasks_{max_tasks, [this] { ::eventfd_write(event_.get(), 1); }};
};

}  // namespace camrig
