#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <utility>

namespace camrig {

/// One place between one who brings values and one reader, for whom only the newest counts.
///
/// `wake` tells the reader that there is something: once, until it has found the slot empty. It is called under the
/// slot's lock, so never after close(), and must not block.
template <typename T>
class LatestSlot {
public:
    explicit LatestSlot(std::function<void()> wake) : wake_reader_(std::move(wake)) {}

    /// What has no place: the value that waited until now; the new one itself when the slot is closed.
    std::optional<T> put(T value) {
        std::lock_guard lock(mutex_);
        if (is_closed_) return value;
        std::optional<T> replaced = std::exchange(value_, std::move(value));
        if (!std::exchange(is_told_, true)) wake_reader_();
        return replaced;
    }
    /// The reader calls it until it gives nothing; only then is it woken again.
    std::optional<T> take() {
        std::lock_guard lock(mutex_);
        if (!value_) is_told_ = false;
        return std::exchange(value_, std::nullopt);
    }
    /// Nothing comes in any more. Gives the value that waited.
    std::optional<T> close() {
        std::lock_guard lock(mutex_);
        is_closed_ = true;
        return std::exchange(value_, std::nullopt);
    }

private:
    const std::function<void()> wake_reader_;
    std::mutex mutex_;
    std::optional<T> value_;
    bool is_told_ = false;
    bool is_closed_ = false;
};

}  // namespace camrig
