#pragma once

#include <memory>
#include <thread>

#include "core/stream/frame_bus.h"
#include "v4l2_sink/loopback/kernel.h"
#include "v4l2_sink/loopback/loopback_host.h"

namespace camrig {

/// Whether this machine can give a camera /dev/video<number>, as far as one sees without trying: the module is there,
/// and so is the device or the right to make it. Changes nothing and does not wait; any thread. The errors say what to
/// run.
Result<void> check_loopback(int number, const std::string& camera, LoopbackKernel& kernel = linux_kernel());

/// The rig's devices of the kernel module v4l2loopback: one thread of its own; calls from any thread never wait.
/// What cannot be done is logged, with what to run, and tried again: a module that is loaded later is used then.
class LoopbackServer {
public:
    /// Bus and fetcher must outlive the server.
    LoopbackServer(FrameBus& bus, FrameFetcher& fetcher, LoopbackHost::Options options,
                   LoopbackKernel& kernel = linux_kernel());
    /// Devices that the rig made are removed.
    ~LoopbackServer();

    void set(LoopbackWish wish);
    void unset(int number);

private:
    void run();

    const std::shared_ptr<TaskQueue> tasks_ = std::make_shared<TaskQueue>();
    std::unique_ptr<LoopbackHost> host_;  ///< the thread's
    bool stopping_ = false;               ///< the thread's
    std::thread thread_;
};

}  // namespace camrig
