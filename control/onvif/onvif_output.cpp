#include "control/onvif/onvif_output.h"

#include "core/base/tcp_listener.h"

namespace camrig::onvif {

Result<void> DevicePorts::check(std::uint16_t port) {
    const std::lock_guard lock(mutex_);
    if (held_.contains(port)) return {};
    const auto tried = listen_tcp({.name = "onvif",
                                   .port_option = "another port of the output",
                                   .host = address_,
                                   .port = port,
                                   .asks_for_token = true});
    if (!tried) return std::unexpected(tried.error());
    return {};
}

void DevicePorts::hold(std::uint16_t port) {
    const std::lock_guard lock(mutex_);
    held_.insert(port);
}

void DevicePorts::release(std::uint16_t port) {
    const std::lock_guard lock(mutex_);
    const auto one = held_.find(port);
    CHECK(one != held_.end());
    held_.erase(one);
}

OutputFamily onvif_family(std::shared_ptr<DevicePorts> ports) {
    return {.kind = output_kind<OnvifOutput>(
                {.name = "onvif",
                 .doc = "the camera as an ONVIF device of its own, at http://HOST:PORT/onvif/device_service"}),
            .key = "port",
            .is_key_of_rig = true,
            .can_open = [ports = std::move(ports)](const OutputSpec& output, const std::string&) {
                return ports->check(static_cast<std::uint16_t>(options_of<OnvifOutput>(output).port));
            }};
}

OnvifPorts::OnvifPorts(stream::FrameBus& bus, std::shared_ptr<DevicePorts> ports, Doors doors)
    : bus_(bus), ports_(std::move(ports)), doors_(std::move(doors)) {
    bus_.add_observer(this);
}

OnvifPorts::~OnvifPorts() {
    bus_.remove_observer(this);
}

void OnvifPorts::update(const stream::CameraStream& camera, bool is_there) {
    const stream::CameraOutputs::Change change = outputs_.update(camera, is_there);
    const auto port_of = [](const OutputSpec& output) {
        return static_cast<std::uint16_t>(options_of<OnvifOutput>(output).port);
    };
    for (const OutputSpec& output : change.gone) close(camera.name, port_of(output));
    for (const OutputSpec& output : change.added) open(camera.name, port_of(output));
}

void OnvifPorts::open(const std::string& camera, std::uint16_t port) {
    ports_->hold(port);
    doors_.open(camera, port, [ports = ports_, tell = doors_.tell, camera, port](bool is_open) {
        if (!is_open) return ports->release(port);
        if (tell) tell(camera, port, true);
    });
}

void OnvifPorts::close(const std::string& camera, std::uint16_t port) {
    doors_.close(camera, port, [ports = ports_, tell = doors_.tell, camera, port](bool was_open) {
        if (!was_open) return;
        ports->release(port);
        if (tell) tell(camera, port, false);
    });
}

}  // namespace camrig::onvif
