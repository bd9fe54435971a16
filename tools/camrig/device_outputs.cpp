#include "tools/camrig/device_outputs.h"

#include <spdlog/spdlog.h>

#include "v4l2_sink/media_format.h"

namespace camrig {

Result<std::unique_ptr<DeviceOutputs>> DeviceOutputs::create(FrameBus& bus, CommandPort& commands,
                                                             const std::string& socket_path) {
    auto controls = std::make_shared<CameraControls>(commands);
    DeviceServerOptions options;
    options.socket_path = socket_path;
    options.controls = controls;
    auto server = DeviceServer::create(bus, std::move(options));
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
    plug(camera, true);
}

void DeviceOutputs::camera_changed(const CameraStream& camera) {
    plug(camera, true);
}

void DeviceOutputs::camera_removed(const CameraStream& camera) {
    controls_->forget(camera.name);
    plug(camera, false);
}

void DeviceOutputs::camera_adjusted(const CameraStream& camera) {
    controls_->refresh(camera.name);
}

void DeviceOutputs::plug(const CameraStream& camera, bool is_there) {
    std::map<int, ChromaSampling> wanted;
    for (const OutputSpec& output : camera.outputs)
        if (is_there && output.kind == "device" && output.number)
            wanted.emplace(*output.number, mjpg_sampling_of(output));
    for (auto it = plugged_.begin(); it != plugged_.end();) {
        const auto kept = wanted.find(it->first);
        if (it->second.camera != camera.name || (kept != wanted.end() && kept->second == it->second.mjpg_sampling)) {
            ++it;
            continue;
        }
        server_->remove_device(it->first);
        it = plugged_.erase(it);
    }
    for (const auto& [number, mjpg_sampling] : wanted) {
        if (plugged_.contains(number)) continue;
        if (const auto added = server_->add_device(number, camera.name, mjpg_sampling); !added) {
            spdlog::error("camera {}: /dev/video{}: {}", camera.name, number, added.error().message);
            continue;
        }
        plugged_.emplace(number, Plugged{camera.name, mjpg_sampling});
    }
}

}  // namespace camrig
