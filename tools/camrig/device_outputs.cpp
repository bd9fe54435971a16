#include "tools/camrig/device_outputs.h"

#include <spdlog/spdlog.h>

#include "v4l2_sink/preload/device_output.h"

namespace camrig {

Result<std::unique_ptr<DeviceOutputs>> DeviceOutputs::create(FrameBus& bus, CommandPort& commands,
                                                             const std::string& socket_path) {
    auto controls = std::make_shared<CameraControls>(commands);
    auto server = DeviceServer::create(bus, socket_path, controls);
    if (!server) return std::unexpected(server.error());
    std::unique_ptr<DeviceOutputs> outputs(new DeviceOutputs(bus, std::move(controls), std::move(*server)));
    bus.add_observer(outputs.get());
    return outputs;
}

DeviceOutputs::DeviceOutputs(FrameBus& bus, std::shared_ptr<CameraControls> controls,
                             std::unique_ptr<DeviceServer> server)
    : bus_(bus), controls_(std::move(controls)), server_(std::move(server)) {
    controls_->on_change([this](const std::string& camera, const std::vector<std::uint32_t>& ids) {
        server_->controls_changed(camera, ids);
    });
}

DeviceOutputs::~DeviceOutputs() {
    bus_.remove_observer(this);
    controls_->on_change({});
}

void DeviceOutputs::camera_added(const CameraStream& camera) {
    controls_->refresh(camera.name);
    update(camera, true);
}

void DeviceOutputs::camera_changed(const CameraStream& camera) {
    update(camera, true);
}

void DeviceOutputs::camera_removed(const CameraStream& camera) {
    controls_->forget(camera.name);
    update(camera, false);
}

void DeviceOutputs::camera_adjusted(const CameraStream& camera) {
    controls_->refresh(camera.name);
}

void DeviceOutputs::update(const CameraStream& camera, bool is_there) {
    const CameraOutputs::Change change = outputs_.update(camera, is_there);
    for (const auto& ended : {change.gone, change.changed})
        for (const OutputSpec& output : ended) server_->remove_device(options_of<DeviceOutput>(output).number);
    for (const auto& begun : {change.changed, change.added}) {
        for (const OutputSpec& output : begun) {
            const auto options = options_of<DeviceOutput>(output);
            if (const auto added = server_->add_device(options.number, camera.name, options.subsampling); !added)
                spdlog::error("camera {}: /dev/video{}: {}", camera.name, options.number, added.error().message);
        }
    }
}

}  // namespace camrig
