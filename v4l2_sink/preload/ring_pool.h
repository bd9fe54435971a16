#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/stream/frame_bus.h"
#include "v4l2_sink/preload/device_session.h"
#include "v4l2_sink/task_queue.h"

namespace camrig::device {

/// The frame rings that programs read: one for each camera, format, size and rate. A ring is subscribed to the frame
/// bus for as long as anybody holds a reference to it. Device server's thread.
class RingPool {
public:
    /// `lost` is called with each ring whose camera was deleted.
    RingPool(stream::FrameBus& bus, std::shared_ptr<TaskQueue> tasks,
             std::function<void(const std::shared_ptr<FedRing>&)> lost, bool is_lockstep = false)
        : bus_(bus), tasks_(std::move(tasks)), lost_(std::move(lost)), is_lockstep_(is_lockstep) {}

    /// The ring of this format, existing or new; not_found when the bus has no such camera.
    Result<std::shared_ptr<FedRing>> take(const std::string& camera, const camrig_format& format,
                                          codec::ChromaSampling mjpg_sampling);
    /// Repeats the last frame of cameras that send none (DeviceRing::repeat_if_idle). Not in lockstep, where nothing
    /// may happen that a client did not ask for.
    void tick(TimeNs monotonic_ns);

private:
    Result<void> feed(const std::shared_ptr<FedRing>& ring);
    void ended(const std::shared_ptr<FedRing>& ring, bool is_gone);

    stream::FrameBus& bus_;
    const std::shared_ptr<TaskQueue> tasks_;
    const std::function<void(const std::shared_ptr<FedRing>&)> lost_;
    const bool is_lockstep_;
    std::vector<std::weak_ptr<FedRing>> rings_;
};

}  // namespace camrig::device
