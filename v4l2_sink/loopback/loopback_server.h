#pragma once

#include <memory>
#include <thread>

#include "core/stream/camera_outputs.h"
#include "v4l2_sink/loopback/kernel.h"
#include "v4l2_sink/loopback/loopback_host.h"

namespace camrig::device {

/// Whether this machine can give a camera /dev/video<number>, as far as one sees without trying: the module is there,
/// and so is the device or the right to make it. Changes nothing and does not wait; any thread. The errors say what to
/// run.
Result<void> check_loopback(int number, const std::string& camera, LoopbackKernel& kernel = linux_kernel());

/// Serves the outputs {kind: "v4l2"} of all cameras of a bus, as cameras are added, changed and removed: devices of the
/// kernel module v4l2loopback. One thread of its own; the bus never waits for it. A failure is logged, with the command
/// that repairs it, and retried: a module that is loaded later is used then.
class LoopbackServer final : public stream::CameraObserver {
public:
    /// Bus and fetcher must outlive the server.
    LoopbackServer(stream::FrameBus& bus, stream::FrameFetcher& fetcher, LoopbackHost::Options options);
    /// Removes the devices that the rig created (~LoopbackHost()).
    ~LoopbackServer() override;

    void camera_added(const stream::CameraStream& camera) override { update(camera, true); }
    void camera_changed(const stream::CameraStream& camera) override { update(camera, true); }
    void camera_removed(const stream::CameraStream& camera) override { update(camera, false); }

private:
    void update(const stream::CameraStream& camera, bool is_there);
    void run();

    stream::FrameBus& bus_;
    stream::CameraOutputs outputs_{"v4l2"};
    const std::shared_ptr<TaskQueue> tasks_ = std::make_shared<TaskQueue>();
    std::unique_ptr<LoopbackHost> host_;  ///< the thread's
    bool stopping_ = false;               ///< the thread's
    std::thread thread_;
};

}  // namespace camrig::device
