#include "control/onvif/device_manners.h"

#include "core/base/field_of.h"
#include "core/base/output_family.h"

namespace camrig::onvif {

std::span<const Named<MoveStatus>> names_of(std::type_identity<MoveStatus>) {
    static constexpr Named<MoveStatus> names[] = {
        {MoveStatus::told, "told"}, {MoveStatus::none, "none"}, {MoveStatus::stuck, "stuck"}};
    return names;
}

FieldTable<OnvifOutput> fields_of(std::type_identity<OnvifOutput>) {
    static const std::vector<FieldOf<OnvifOutput>> table{
        field_at<&OnvifOutput::port>({.name = "port",
                                      .doc = "TCP port of the device, on the host of HTTP",
                                      .required = true,
                                      .range = {1, 65535}}),
        field_at<&OnvifOutput::move_status>(
            {.name = "move_status",
             .doc = "whether the head moves is told as it is, not at all, or as MOVING for ever after the first move"}),
        field_at<&OnvifOutput::has_relative_fov>(
            {.name = "relative_fov",
             .doc = "offers moves by field of view, which trackers need and many devices lack"})};
    return table;
}

OnvifOutput manners_of(const world::CameraSpec& camera, std::uint16_t port) {
    for (const OutputSpec& output : camera.outputs)
        if (output.kind == "onvif")
            if (const auto options = options_of<OnvifOutput>(output); options.port == port) return options;
    return {};
}

}  // namespace camrig::onvif
