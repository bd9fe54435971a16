#include "control/onvif/onvif_output.h"

namespace camrig::onvif {

FieldTable<OnvifOutput> fields_of(std::type_identity<OnvifOutput>) {
    static const std::vector<FieldOf<OnvifOutput>> table{field_at<&OnvifOutput::port>(
        {.name = "port", .doc = "TCP port of the device, on the host of HTTP", .required = true, .range = {1, 65535}})};
    return table;
}

OutputFamily onvif_family() {
    return {.kind = output_kind<OnvifOutput>(
                {.name = "onvif",
                 .doc = "the camera as an ONVIF device of its own, at http://HOST:PORT/onvif/device_service"}),
            .key = "port",
            .is_key_of_rig = true};
}

OnvifPorts::OnvifPorts(stream::FrameBus& bus, Doors doors) : bus_(bus), doors_(std::move(doors)) {
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
    for (const OutputSpec& output : change.gone) doors_.close(camera.name, port_of(output));
    for (const OutputSpec& output : change.added) doors_.open(camera.name, port_of(output));
}

}  // namespace camrig::onvif
