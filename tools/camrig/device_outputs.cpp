#include "tools/camrig/device_outputs.h"

#include <set>

#include <spdlog/spdlog.h>

namespace camrig {

Result<std::unique_ptr<DeviceOutputs>> DeviceOutputs::create(FrameBus& bus, const std::string& socket_path) {
    DeviceServerOptions options;
    options.socket_path = socket_path;
    auto server = DeviceServer::create(bus, std::move(options));
    if (!server) return std::unexpected(server.error());
    std::unique_ptr<DeviceOutputs> outputs(new DeviceOutputs(bus, std::move(*server)));
    bus.add_observer(outputs.get());
    return outputs;
}

DeviceOutputs::DeviceOutputs(FrameBus& bus, std::unique_ptr<DeviceServer> server)
    : bus_(bus), server_(std::move(server)) {}

DeviceOutputs::~DeviceOutputs() {
    bus_.remove_observer(this);
}

void DeviceOutputs::camera_added(const CameraStream& camera) {
    plug(camera, true);
}

void DeviceOutputs::camera_changed(const CameraStream& camera) {
    plug(camera, true);
}

void DeviceOutputs::camera_removed(const CameraStream& camera) {
    plug(camera, false);
}

void DeviceOutputs::plug(const CameraStream& camera, bool is_there) {
    std::set<int> wanted;
    for (const OutputSpec& output : camera.outputs)
        if (is_there && output.kind == "device" && output.number) wanted.insert(*output.number);
    for (auto it = plugged_.begin(); it != plugged_.end();) {
        if (it->second != camera.name || wanted.contains(it->first)) {
            ++it;
            continue;
        }
        server_->remove_device(it->first);
        it = plugged_.erase(it);
    }
    for (const int number : wanted) {
        if (plugged_.contains(number)) continue;
        if (const auto added = server_->add_device(number, camera.name); !added) {
            spdlog::error("camera {}: /dev/video{}: {}", camera.name, number, added.error().message);
            continue;
        }
        plugged_.emplace(number, camera.name);
    }
}

}  // namespace camrig
