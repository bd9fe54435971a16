#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "control/onvif/device_manners.h"
#include "core/base/output_family.h"
#include "core/stream/camera_outputs.h"

namespace camrig::onvif {

/// Which ports this rig can have, on the address that it listens on. Any thread; nothing waits.
class DevicePorts {
public:
    /// As a number (resolve_address()): no name is looked up.
    explicit DevicePorts(std::string address) : address_(std::move(address)) {}
    /// unavailable: another program has it. One that is held is not asked for: it is the rig's.
    Result<void> check(std::uint16_t port);
    /// A port is held from when it is going to be opened until it is closed or could not be opened. Calls are counted:
    /// one device may close the port that another is going to open.
    void hold(std::uint16_t port);
    void release(std::uint16_t port);

private:
    const std::string address_;
    std::mutex mutex_;
    std::multiset<std::uint16_t> held_;
};

OutputFamily onvif_family(std::shared_ptr<DevicePorts> ports);

/// Opens and closes the ports of the outputs {kind: "onvif"} as cameras come, change and go.
class OnvifPorts final : public stream::CameraObserver {
public:
    using Done = std::function<void(bool)>;
    /// What opens and closes ports: the server. None of them blocks, and what they ask for is done in the order of the
    /// calls. They must work until this is destroyed.
    struct Doors {
        /// `done` is told whether it is open.
        std::function<void(const std::string& camera, std::uint16_t port, Done done)> open;
        /// `done` is told whether it was open.
        std::function<void(const std::string& camera, std::uint16_t port, Done done)> close;
        /// Tells those who look for devices that the camera is at this port, or no longer. Empty: nobody is told.
        std::function<void(const std::string& camera, std::uint16_t port, bool is_there)> tell = {};
    };
    /// The bus outlives this.
    OnvifPorts(stream::FrameBus& bus, std::shared_ptr<DevicePorts> ports, Doors doors);
    ~OnvifPorts() override;

    void camera_added(const stream::CameraStream& camera) override { update(camera, true); }
    void camera_changed(const stream::CameraStream& camera) override { update(camera, true); }
    void camera_removed(const stream::CameraStream& camera) override { update(camera, false); }

private:
    void update(const stream::CameraStream& camera, bool is_there);
    void open(const std::string& camera, std::uint16_t port);
    void close(const std::string& camera, std::uint16_t port);

    stream::FrameBus& bus_;
    const std::shared_ptr<DevicePorts> ports_;
    const Doors doors_;
    stream::CameraOutputs outputs_{"onvif"};
};

}  // namespace camrig::onvif
