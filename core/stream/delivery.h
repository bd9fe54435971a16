#pragma once

#include <condition_variable>
#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/time.h"

namespace camrig {

/// Knows when everything that was published at one instant has reached (or finally missed) its readers.
///
/// Whoever still has to deliver keeps a Hold; the last Hold to go opens the latch. In lockstep the engine waits for it;
/// in realtime nobody makes one and all holds are empty. Any thread.
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

    static std::shared_ptr<DeliveryLatch> create() { return std::make_shared<DeliveryLatch>(); }

    /// `who` is told to the user when the wait takes too long, e.g. "MJPEG reader 127.0.0.1:5123 of camera lobby".
    Hold hold(std::string who);
    /// True once no hold is left; false after the time limit (CLOCK_MONOTONIC).
    bool wait_until(TimeNs monotonic_ns);
    /// Who still holds.
    std::vector<std::string> holders() const;

private:
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::list<std::string> holders_;
};

/// A new hold on the latch, or an empty one when there is no latch.
inline DeliveryLatch::Hold hold_if(const std::shared_ptr<DeliveryLatch>& latch, std::string who) {
    return latch ? latch->hold(std::move(who)) : DeliveryLatch::Hold{};
}

}  // namespace camrig
