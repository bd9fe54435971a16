#pragma once

#include <map>
#include <string>

#include "core/stream/frame_bus.h"
#include "v4l2_sink/loopback/loopback_server.h"

namespace camrig {

/// Gives cameras with an output {kind: "v4l2", number: N, format: F} the device /dev/videoN of the kernel module
/// v4l2loopback, as they come, change and go.
class LoopbackOutputs final : public CameraObserver {
public:
    LoopbackOutputs(FrameBus& bus, FrameFetcher& fetcher, LoopbackHost::Options options);
    ~LoopbackOutputs() override;

    void camera_added(const CameraStream& camera) override;
    void camera_changed(const CameraStream& camera) override;
    void camera_removed(const CameraStream& camera) override;

private:
    void plug(const CameraStream& camera, bool is_there);

    FrameBus& bus_;
    LoopbackServer server_;
    std::map<int, std::string> plugged_;  ///< number -> camera; the bus calls observers one at a time
};

}  // namespace camrig
