#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/result.h"
#include "core/stream/frame_bus.h"
#include "tools/camrig/camera_controls.h"
#include "v4l2_sink/preload/device_server.h"

namespace camrig {

/// Plugs cameras with an output {kind: "device", number: N} in as /dev/videoN and out again, as they come, change and
/// go.
class DeviceOutputs final : public CameraObserver {
public:
    /// `commands`: where the devices' controls go; it must outlive the bus's cameras.
    static Result<std::unique_ptr<DeviceOutputs>> create(FrameBus& bus, CommandPort& commands,
                                                         const std::string& socket_path);
    ~DeviceOutputs() override;

    void camera_added(const CameraStream& camera) override;
    void camera_changed(const CameraStream& camera) override;
    void camera_removed(const CameraStream& camera) override;
    void camera_adjusted(const CameraStream& camera) override;

private:
    DeviceOutputs(FrameBus& bus, std::shared_ptr<CameraControls> controls, std::unique_ptr<DeviceServer> server);
    void plug(const CameraStream& camera, bool is_there);

    FrameBus& bus_;
    const std::shared_ptr<CameraControls> controls_;
    const std::unique_ptr<DeviceServer> server_;
    std::map<int, std::string> plugged_;  ///< number -> camera; the bus calls observers one at a time
};

}  // namespace camrig
