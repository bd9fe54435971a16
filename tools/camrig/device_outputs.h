#pragma once

#include <map>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/stream/camera_outputs.h"
#include "tools/camrig/camera_controls.h"
#include "v4l2_sink/preload/device_server.h"

namespace camrig::cli {

/// Opens the outputs {kind: "device"} of the cameras of a bus, as cameras come, change and go. The few small files of a
/// device are written before the call returns: who has the answer to camera.create finds /dev/videoN. What cannot be
/// opened is tried again whenever a camera changes.
class DeviceOutputs final : public stream::CameraObserver {
public:
    /// `commands`: where the devices' controls go; it must outlive the bus's cameras. `is_lockstep`: no picture is
    /// repeated (DeviceServer).
    static Result<std::unique_ptr<DeviceOutputs>> create(stream::FrameBus& bus, engine::CommandPort& commands,
                                                         const std::string& socket_path, bool is_lockstep = false);
    ~DeviceOutputs() override;

    void camera_added(const stream::CameraStream& camera) override;
    void camera_changed(const stream::CameraStream& camera) override;
    void camera_removed(const stream::CameraStream& camera) override;
    void camera_adjusted(const stream::CameraStream& camera) override;

private:
    DeviceOutputs(stream::FrameBus& bus, std::shared_ptr<CameraControls> controls,
                  std::unique_ptr<device::DeviceServer> server);
    void update(const stream::CameraStream& camera, bool is_there);
    /// Those that are not open: new ones, and again those that could not be opened.
    void open_devices();

    stream::FrameBus& bus_;
    const std::shared_ptr<CameraControls> controls_;
    const std::unique_ptr<device::DeviceServer> server_;
    stream::CameraOutputs outputs_{"device"};
    struct Unopened {
        std::string camera;
        codec::ChromaSampling subsampling{};
        std::string complaint;  ///< that was logged last
    };
    std::map<int, Unopened> unopened_;  ///< by number
};

}  // namespace camrig::cli
