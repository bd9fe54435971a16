#include "core/stream/delivery.h"

#include <utility>

namespace camrig::stream {

std::shared_ptr<DeliveryLatch> DeliveryLatch::create(std::function<void()> on_open) {
    auto latch = std::make_shared<DeliveryLatch>();
    latch->on_open_ = std::move(on_open);
    return latch;
}

DeliveryLatch::Hold& DeliveryLatch::Hold::operator=(Hold&& other) noexcept {
    if (this != &other) {
        release();
        latch_ = std::move(other.latch_);
        place_ = other.place_;
    }
    return *this;
}

void DeliveryLatch::Hold::release() {
    const auto latch = std::exchange(latch_, nullptr);
    if (!latch) return;
    bool opened = false;
    {
        std::lock_guard lock(latch->mutex_);
        latch->holders_.erase(place_);
        opened = latch->holders_.empty();
    }
    if (opened && latch->on_open_) latch->on_open_();
}

DeliveryLatch::Hold DeliveryLatch::hold(std::string who) {
    Hold hold;
    hold.latch_ = shared_from_this();
    std::lock_guard lock(mutex_);
    hold.place_ = holders_.insert(holders_.end(), std::move(who));
    return hold;
}

bool DeliveryLatch::is_open() const {
    std::lock_guard lock(mutex_);
    return holders_.empty();
}

std::vector<std::string> DeliveryLatch::holders() const {
    std::lock_guard lock(mutex_);
    return {holders_.begin(), holders_.end()};
}

}  // namespace camrig::stream
