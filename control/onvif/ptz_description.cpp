#include "control/onvif/ptz_description.h"

#include "control/onvif/ptz_space.h"
#include "control/onvif/xml.h"

namespace camrig::onvif {
namespace {

std::string range(std::string_view name, double low, double high) {
    return element(name, element("tt:Min", number(low)) + element("tt:Max", number(high)));
}

std::string plane(std::string_view tag, std::string_view space) {
    return element(tag, element("tt:URI", space) + range("tt:XRange", -1, 1) + range("tt:YRange", -1, 1));
}

std::string line(std::string_view tag, std::string_view space, double low) {
    return element(tag, element("tt:URI", space) + range("tt:XRange", low, 1));
}

}  // namespace

std::string ptz_spaces(bool has_fov) {
    return plane("tt:AbsolutePanTiltPositionSpace", position_space) +
           line("tt:AbsoluteZoomPositionSpace", zoom_position_space, 0) +
           plane("tt:RelativePanTiltTranslationSpace", translation_space) +
           (has_fov ? plane("tt:RelativePanTiltTranslationSpace", fov_space) : "") +
           line("tt:RelativeZoomTranslationSpace", zoom_translation_space, -1) +
           plane("tt:ContinuousPanTiltVelocitySpace", velocity_space) +
           line("tt:ContinuousZoomVelocitySpace", zoom_velocity_space, -1) +
           line("tt:PanTiltSpeedSpace", speed_space, 0) + line("tt:ZoomSpeedSpace", zoom_speed_space, 0);
}

std::string ptz_node(const world::CameraSpec& spec, bool has_fov, std::string_view tag) {
    return element(tag,
                   text_element("tt:Name", spec.name) + element("tt:SupportedPTZSpaces", ptz_spaces(has_fov)) +
                       element("tt:MaximumNumberOfPresets", std::to_string(camera::PtzHead::max_presets)) +
                       "<tt:HomeSupported>true</tt:HomeSupported>" + element("tt:AuxiliaryCommands", wiper_on) +
                       element("tt:AuxiliaryCommands", wiper_off),
                   "token=\"" + spec.name + "\" FixedHomePosition=\"false\"");
}

std::string ptz_position(const world::CameraSpec& spec, const camera::PtzPosition& at, std::string_view tag) {
    const camera::PtzSpec& head = *spec.ptz;
    return element(tag, element("tt:PanTilt", "",
                                "x=\"" + number(pan_generic(head, at.pan_deg)) + "\" y=\"" +
                                    number(axis_of(head.tilt_limits_deg).generic(at.tilt_deg)) + "\" space=\"" +
                                    std::string(position_space) + "\"") +
                            element("tt:Zoom", "",
                                    "x=\"" + number(zoom_generic(head, at.zoom)) + "\" space=\"" +
                                        std::string(zoom_position_space) + "\""));
}

std::string ptz_configuration(const world::CameraSpec& spec, std::string_view tag) {
    const auto space = [](std::string_view name, std::string_view uri) { return element(name, uri); };
    return element(
        tag,
        text_element("tt:Name", spec.name) + "<tt:UseCount>2</tt:UseCount>" + text_element("tt:NodeToken", spec.name) +
            // The schema has it with this error.
            space("tt:DefaultAbsolutePantTiltPositionSpace", position_space) +
            space("tt:DefaultAbsoluteZoomPositionSpace", zoom_position_space) +
            space("tt:DefaultRelativePanTiltTranslationSpace", translation_space) +
            space("tt:DefaultRelativeZoomTranslationSpace", zoom_translation_space) +
            space("tt:DefaultContinuousPanTiltVelocitySpace", velocity_space) +
            space("tt:DefaultContinuousZoomVelocitySpace", zoom_velocity_space) +
            element(
                "tt:DefaultPTZSpeed",
                element("tt:PanTilt", "", "x=\"1.000000\" y=\"1.000000\" space=\"" + std::string(speed_space) + "\"") +
                    element("tt:Zoom", "", "x=\"1.000000\" space=\"" + std::string(zoom_speed_space) + "\"")) +
            "<tt:DefaultPTZTimeout>PT10S</tt:DefaultPTZTimeout>" +
            element("tt:PanTiltLimits", plane("tt:Range", position_space)) +
            element("tt:ZoomLimits", line("tt:Range", zoom_position_space, 0)),
        "token=\"" + spec.name + "\"");
}

}  // namespace camrig::onvif
