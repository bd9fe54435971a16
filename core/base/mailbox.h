#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

namespace camrig {

/// One slot; the newest value wins. Any thread may put or take; neither ever blocks on the other side.
template <typename T>
class Mailbox {
public:
    /// Puts a value and returns the one it replaced, if nobody had taken it (the caller counts it as dropped).
    std::optional<T> put(T value) {
        std::lock_guard lock(mutex_);
        std::optional<T> replaced = std::move(slot_);
        slot_ = std::move(value);
        return replaced;
    }
    std::optional<T> take() {
        std::lock_guard lock(mutex_);
        return std::exchange(slot_, std::nullopt);
    }

private:
    std::mutex mutex_;
    std::optional<T> slot_;
};

}  // namespace camrig
