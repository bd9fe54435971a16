#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "core/base/output_family.h"
#include "core/stream/camera_outputs.h"

namespace camrig::onvif {

/// The options of an output {kind: "onvif"}: the camera as an ONVIF device of its own.
struct OnvifOutput {
    int port = 0;  ///< of TCP
};
FieldTable<OnvifOutput> fields_of(std::type_identity<OnvifOutput>);

/// Which ports this rig can have, on the host that it listens on. Any thread.
class DevicePorts {
public:
    explicit DevicePorts(std::string host) : host_(std::move(host)) {}
    /// unavailable: another program has it. One that the rig had once is not asked for, as it may be about to close it.
    Result<void> check(std::uint16_t port);
    void had(std::uint16_t port);

private:
    const std::string host_;
    std::mutex mutex_;
    std::set<std::uint16_t> had_;
};

OutputFamily onvif_family(std::shared_ptr<DevicePorts> ports);

/// Opens and closes the ports of the outputs {kind: "onvif"} as cameras come, change and go.
class OnvifPorts final : public stream::CameraObserver {
public:
    /// Neither waits, and both outlive the bus's last word to this.
    struct Doors {
        std::function<void(const std::string& camera, std::uint16_t port)> open;
        std::function<void(const std::string& camera, std::uint16_t port)> close;
    };
    /// The bus outlives this.
    OnvifPorts(stream::FrameBus& bus, Doors doors);
    ~OnvifPorts() override;

    void camera_added(const stream::CameraStream& camera) override { update(camera, true); }
    void camera_changed(const stream::CameraStream& camera) override { update(camera, true); }
    void camera_removed(const stream::CameraStream& camera) override { update(camera, false); }

private:
    void update(const stream::CameraStream& camera, bool is_there);

    stream::FrameBus& bus_;
    const Doors doors_;
    stream::CameraOutputs outputs_{"onvif"};
};

}  // namespace camrig::onvif
