#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace camrig::stream {

/// Knows when everything that was published at one instant has reached (or finally missed) its readers.
///
/// Whoever still has to deliver keeps a Hold; the last Hold to go opens the latch. A step, in lockstep or of a world
/// that is paused in real time, waits for it; else nobody makes one and all holds are empty. Any thread.
class DeliveryLatch : public std::enable_shared_from_this<DeliveryLatch> {
public:
    class Hold {
    public:
        Hold() = default;
        Hold(Hold&& other) noexcept = default;
        Hold& operator=(Hold&& other) noexcept;
        ~Hold() { release(); }
        void release();

    private:
        friend class DeliveryLatch;
        std::shared_ptr<DeliveryLatch> latch_;
        std::list<std::string>::iterator place_;
    };

    /// on_open (may be empty) is called each time the last hold goes, from the thread that let it go; it must not
    /// block.
    static std::shared_ptr<DeliveryLatch> create(std::function<void()> on_open = {});

    /// `who` is told to the user when the wait takes too long, e.g. "MJPEG reader 127.0.0.1:5123 of camera lobby".
    Hold hold(std::string who);
    /// True when nobody holds.
    bool is_open() const;
    /// Who still holds.
    std::vector<std::string> holders() const;

private:
    mutable std::mutex mutex_;
    std::list<std::string> holders_;
    std::function<void()> on_open_;
};

/// A new hold on the latch, or an empty one when there is no latch.
inline DeliveryLatch::Hold hold_if(const std::shared_ptr<DeliveryLatch>& latch, std::string who) {
    return latch ? latch->hold(std::move(who)) : DeliveryLatch::Hold{};
}

}  // namespace camrig::stream
