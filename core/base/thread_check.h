#pragma once

#include <atomic>
#include <thread>

#include "core/base/result.h"

namespace camrig {

/// Binds an object to the first thread that calls check(); any other thread afterwards is our bug.
class ThreadCheck {
public:
    void check() {
        std::thread::id nobody{};
        const auto self = std::this_thread::get_id();
        if (!owner_.compare_exchange_strong(nobody, self)) CHECK(nobody == self);
    }
    /// Lets the next caller become the owner (hand-over between threads).
    void release() { owner_.store(std::thread::id{}); }

private:
    std::atomic<std::thread::id> owner_{};
};

}  // namespace camrig
