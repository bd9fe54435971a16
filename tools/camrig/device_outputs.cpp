#include "tools/camrig/device_outputs.h"

#include <spdlog/spdlog.h>

#include "v4l2_sink/preload/device_output.h"

namespace camrig::cli {

Result<std::unique_ptr<DeviceOutputs>> DeviceOutputs::create(stream::FrameBus& bus, engine::CommandPort& commands,
                                                             const std::string& socket_path, bool is_lockstep) {
    auto controls = std::make_shared<CameraControls>(commands);
    auto server = device::DeviceServer::create(bus, socket_path, controls, is_lockstep);
    if (!server) return std::unexpected(server.error());
    std::unique_ptr<DeviceOutputs> outputs(new DeviceOutputs(bus, std::move(controls), std::move(*server)));
    bus.add_observer(outputs.get());
    return outputs;
}

DeviceOutputs::DeviceOutputs(stream::FrameBus& bus, std::shared_ptr<CameraControls> controls,
                             std::unique_ptr<device::DeviceServer> server)
    : bus_(bus), controls_(std::move(controls)), server_(std::move(server)) {
    controls_->on_change([this](const std::string& camera, const std::vector<std::uint32_t>& ids) {
        server_->controls_changed(camera, ids);
    });
}

DeviceOutputs::~DeviceOutputs() {
    bus_.remove_observer(this);
    controls_->on_change({});
}

void DeviceOutputs::camera_added(const stream::CameraStream& camera) {
    controls_->refresh(camera.name);
    update(camera, true);
}

void DeviceOutputs::camera_changed(const stream::CameraStream& camera) {
    server_->set_standing(camera.name, camera.standing);
    update(camera, true);
}

void DeviceOutputs::camera_removed(const stream::CameraStream& camera) {
    controls_->forget(camera.name);
    server_->set_standing(camera.name, {});
    update(camera, false);
}

void DeviceOutputs::camera_adjusted(const stream::CameraStream& camera) {
    // Nobody asks for controls of a camera without a device; one that gets its first is adjusted too.
    if (std::ranges::find(camera.outputs, "device", &OutputSpec::kind) != camera.outputs.end())
        controls_->refresh(camera.name);
    open_devices();
}

void DeviceOutputs::update(const stream::CameraStream& camera, bool is_there) {
    const stream::CameraOutputs::Change change = outputs_.update(camera, is_there);
    for (const auto& ended : {change.gone, change.changed}) {
        for (const OutputSpec& output : ended) {
            const int number = options_of<device::DeviceOutput>(output).number;
            if (unopened_.erase(number) == 0) server_->remove_device(number);
        }
    }
    for (const auto& begun : {change.changed, change.added}) {
        for (const OutputSpec& output : begun) {
            const auto options = options_of<device::DeviceOutput>(output);
            unopened_[options.number] = {camera.name, options.subsampling, {}};
        }
    }
    open_devices();
}

void DeviceOutputs::open_devices() {
    for (auto it = unopened_.begin(); it != unopened_.end();) {
        auto& [number, device] = *it;
        const auto added = server_->add_device(number, device.camera, device.subsampling);
        if (!added && std::exchange(device.complaint, added.error().message) != added.error().message)
            spdlog::error("camera {}: /dev/video{}: {}; it is tried again with the next change of a camera",
                          device.camera, number, added.error().message);
        it = added ? unopened_.erase(it) : std::next(it);
    }
}

}  // namespace camrig::cli
