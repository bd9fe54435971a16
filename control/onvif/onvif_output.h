#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "core/base/output_family.h"
#include "core/stream/camera_outputs.h"

namespace camrig::onvif {

/// The options of an output {kind: "onvif"}: the camera as an ONVIF device of its own.
struct OnvifOutput {
    int port = 0;  ///< of TCP
};
FieldTable<OnvifOutput> fields_of(std::type_identity<OnvifOutput>);

OutputFamily onvif_family();

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
