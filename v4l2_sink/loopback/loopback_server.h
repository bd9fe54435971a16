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

/// Opens the outputs {kind: "v4l2"} of the cameras of a bus, as cameras come, change and go: the rig's devices of the
/// kernel module v4l2loopback. One thread of its own; the bus never waits for it. What cannot be done is logged, with
/// what to run, and tried again: a module that is loaded later is used then.
class LoopbackServer final : public stream::CameraObserver {
public:
    /// Bus and fetcher must outlive the server.
    LoopbackServer(stream::FrameBus& bus, stream::FrameFetcher& fetcher, LoopbackHost::Options options);
    /// Devices that the rig made are removed.
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
