#pragma once

#include <memory>
#include <string>
#include <vector>

#include "control/onvif/onvif_output.h"
#include "core/engine/command.h"
#include "core/stream/frame_bus.h"

namespace camrig::cli {

/// What outputs are opened with; all of it must outlive them.
struct OutputHost {
    stream::FrameBus& bus;
    stream::FrameFetcher& fetcher;
    engine::CommandPort& commands;  ///< where the controls of devices go
    std::string device_socket;      ///< of user-space devices
    bool is_lockstep = false;
};

/// Makes the families of outputs known to all who read cameras. Before there are other threads. `ports`: of cameras
/// that are ONVIF devices.
void register_outputs(std::shared_ptr<onvif::DevicePorts> ports = std::make_shared<onvif::DevicePorts>("127.0.0.1"));

/// From now on, and until what it gives is destroyed, opens the outputs of the cameras of the bus, as cameras come,
/// change and go.
Result<std::vector<std::unique_ptr<stream::CameraObserver>>> open_outputs(const OutputHost& host);

}  // namespace camrig::cli
