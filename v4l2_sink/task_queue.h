#pragma once

#include <functional>
#include <mutex>
#include <utility>
#include <vector>

#include <sys/eventfd.h>

#include "core/base/unique_fd.h"

namespace camrig {

/// Work for one thread from others; the descriptor is readable when there is some. post() from any thread.
class TaskQueue {
public:
    TaskQueue() : wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

    int fd() const { return wake_.get(); }
    void post(std::function<void()> task) {
        {
            std::lock_guard lock(mutex_);
            tasks_.push_back(std::move(task));
        }
        ::eventfd_write(wake_.get(), 1);
    }
    std::vector<std::function<void()>> take() {
        eventfd_t ignored;
        ::eventfd_read(wake_.get(), &ignored);
        std::lock_guard lock(mutex_);
        return std::exchange(tasks_, {});
    }

private:
    const UniqueFd wake_;
    std::mutex mutex_;
    std::vector<std::function<void()>> tasks_;
};

}  // namespace camrig
