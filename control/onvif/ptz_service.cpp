#include <algorithm>
#include <utility>

#include "control/onvif/authentication.h"
#include "control/onvif/operation.h"
#include "control/onvif/ptz_description.h"
#include "control/onvif/ptz_presets.h"
#include "control/onvif/ptz_space.h"
#include "control/onvif/ptz_vector.h"
#include "core/camera/ptz_head.h"

// ONVIF PTZ (ver20): how heads are moved, and what they are and answer. Presets: ptz_presets.h.
namespace camrig::onvif {
namespace {

using camera::PtzMode;
using camera::PtzSpec;
using world::CameraSpec;

constexpr TimeNs default_timeout_ns = 10 * ns_per_s;  ///< of a continuous move that names none
const PtzSpec& head_of(const Asked& asked) {
    return *asked.cameras.front()->ptz;
}

Orders absolute_move(const Asked& asked) {
    const auto to =
        read_vector(asked.request.child("Position"), {"InvalidPosition", position_space, zoom_position_space, 0.0});
    if (!to) return std::unexpected(to.error());
    const PtzSpec& head = head_of(asked);
    camera::PtzMove move{.mode = PtzMode::absolute, .speed = speed_of(asked.request.child("Speed"), to->x.has_value())};
    if (to->x) move.pan_deg = pan_axis(head).degrees(*to->x, head.pan_limits_deg);
    if (to->y) move.tilt_deg = axis_of(head.tilt_limits_deg).degrees(*to->y, head.tilt_limits_deg);
    if (to->zoom) move.zoom = std::min(zoom_factor(head, *to->zoom), head.zoom_max);
    return std::vector<PtzCommand>{engine::MovePtz{name_of(asked), move}};
}

Orders relative_move(const Asked& asked) {
    const auto by = read_vector(asked.request.child("Translation"), {.detail = "InvalidTranslation",
                                                                     .space = translation_space,
                                                                     .zoom_space = zoom_translation_space,
                                                                     .takes_fov = asked.manners.has_relative_fov});
    if (!by) return std::unexpected(by.error());
    const PtzSpec& head = head_of(asked);
    camera::PtzMove move{.mode = PtzMode::relative, .speed = speed_of(asked.request.child("Speed"), by->x.has_value())};
    if (by->zoom) move.zoom = zoom_factor(head, *by->zoom);
    if (by->x && by->space == fov_space) {
        move.mode = PtzMode::fov;
        move.x = *by->x;
        move.y = *by->y;
    } else if (by->x) {
        move.pan_deg = *by->x * pan_axis(head).half;
        move.tilt_deg = *by->y * axis_of(head.tilt_limits_deg).half;
    }
    if (!by->x && !by->zoom) return Orders{};
    return std::vector<PtzCommand>{engine::MovePtz{name_of(asked), move}};
}

Orders continuous_move(const Asked& asked) {
    const auto at =
        read_vector(asked.request.child("Velocity"), {"InvalidVelocity", velocity_space, zoom_velocity_space});
    if (!at) return std::unexpected(at.error());
    const PtzSpec& head = head_of(asked);
    const std::string_view given = asked.request.text("Timeout");
    const auto timeout = given.empty() ? std::optional(default_timeout_ns) : duration_of(given);
    if (!timeout) return invalid_argument("TimeoutNotSupported", "Timeout is a duration as PT2.5S, a day at most");
    camera::PtzMove move{.mode = PtzMode::continuous, .timeout = *timeout};
    if (at->x) move.pan_deg = -*at->x * head.speed_deg_s;
    if (at->y) move.tilt_deg = *at->y * head.speed_deg_s;
    if (at->zoom) move.zoom = *at->zoom;
    return std::vector<PtzCommand>{engine::MovePtz{name_of(asked), move}};
}

Orders stop(const Asked& asked) {
    // What is not named stops too.
    const auto stops = [&](const char* axis) {
        const std::string_view text = asked.request.text(axis);
        return text != "false" && text != "0";
    };
    const bool pan_tilt = stops("PanTilt"), zoom = stops("Zoom");
    if (!pan_tilt && !zoom) return std::vector<PtzCommand>{engine::GetPtz{name_of(asked)}};
    return std::vector<PtzCommand>{engine::StopPtz{name_of(asked), pan_tilt, zoom}};
}

/// Auxiliary commands (ONVIF Core, 8.6): a wiper, which wipes when it is told On and rests again by itself.
Orders auxiliary(const Asked& asked) {
    const std::string_view told = asked.request.text("AuxiliaryData");
    if (told == wiper_on)
        return std::vector<PtzCommand>{
            engine::ClearFaults{.id = {}, .camera = name_of(asked), .kind = {}, .by_wiper = true}};
    if (told == wiper_off) return std::vector<PtzCommand>{engine::GetPtz{name_of(asked)}};
    return invalid_argument("AuxiliaryDataNotSupported", "AuxiliaryData is one of the node's AuxiliaryCommands");
}

std::string auxiliary_reply(const Asked& asked, const engine::PtzReply&) {
    return response("tptz:SendAuxiliaryCommand",
                    text_element("tptz:AuxiliaryResponse", asked.request.text("AuxiliaryData")));
}

Orders get(const Asked& asked) {
    return std::vector<PtzCommand>{engine::GetPtz{name_of(asked)}};
}

/// Whether the head moves, as this device tells it.
std::string move_status(const Asked& asked, const engine::PtzReply& told) {
    if (asked.manners.move_status == MoveStatus::none) return "";
    const bool is_stuck = asked.manners.move_status == MoveStatus::stuck && told.arrives_ns > 0;
    const auto state = [&](const char* name, bool is_moving) {
        return element(name, is_moving || is_stuck ? "MOVING" : "IDLE");
    };
    return element("tt:MoveStatus",
                   state("tt:PanTilt", told.status.is_turning) + state("tt:Zoom", told.status.is_zooming));
}

std::string status_reply(const Asked& asked, const engine::PtzReply& told) {
    return response(
        "tptz:GetStatus",
        element("tptz:PTZStatus", ptz_position(*asked.cameras.front(), told.status.position, "tt:Position") +
                                      move_status(asked, told) + element("tt:UtcTime", text_of_time(asked.utc_ns))));
}

std::string of_all_heads(const Asked& asked, std::string (*make)(const Asked&, const CameraSpec&)) {
    std::string all;
    for (const CameraSpecRef& spec : asked.cameras)
        if (spec->ptz) all += make(asked, *spec);
    return all;
}

/// The camera with a head that the request's child names.
Answered<CameraSpecRef> head_named(const Asked& asked, std::string_view child, std::string_view detail) {
    auto camera = camera_of(asked, child, detail);
    if (camera && !(*camera)->ptz) return invalid_argument(detail, "this camera has no head that turns");
    return camera;
}

/// What `make` says of the head that the request's child names.
template <typename Make>
Answer of_head(const Asked& asked, std::string_view operation, std::string_view child, std::string_view detail,
               Make make) {
    const auto camera = head_named(asked, child, detail);
    if (!camera) return std::unexpected(camera.error());
    return response(operation, make(asked, **camera));
}

std::string node(const Asked& asked, const CameraSpec& spec) {
    return ptz_node(spec, asked.manners.has_relative_fov, "tptz:PTZNode");
}

std::string configuration(const Asked&, const CameraSpec& spec) {
    return ptz_configuration(spec, "tptz:PTZConfiguration");
}

std::string configuration_options(const Asked& asked, const CameraSpec&) {
    return element("tptz:PTZConfigurationOptions",
                   element("tt:Spaces", ptz_spaces(asked.manners.has_relative_fov)) +
                       "<tt:PTZTimeout><tt:Min>PT0S</tt:Min><tt:Max>PT86400S</tt:Max></tt:PTZTimeout>");
}

Answer get_service_capabilities(const Asked& asked) {
    // As "true" and not "1": clients whose schema is older than an attribute compare its text.
    const std::string tells = asked.manners.move_status == MoveStatus::none ? "false" : "true";
    return response(
        "tptz:GetServiceCapabilities",
        R"(<tptz:Capabilities EFlip="false" Reverse="false" GetCompatibleConfigurations="true" MoveStatus=")" + tells +
            R"(" StatusPosition="true"/>)");
}

template <const char* Name>
std::string empty_reply(const Asked&, const engine::PtzReply&) {
    return response(Name, "");
}
constexpr char absolute_name[] = "tptz:AbsoluteMove", relative_name[] = "tptz:RelativeMove",
               continuous_name[] = "tptz:ContinuousMove", stop_name[] = "tptz:Stop", goto_name[] = "tptz:GotoPreset",
               remove_name[] = "tptz:RemovePreset", go_home_name[] = "tptz:GotoHomePosition",
               set_home_name[] = "tptz:SetHomePosition";

const Operation operations[] = {
    {"GetServiceCapabilities", get_service_capabilities, Access::pre_auth},
    {"GetNodes", [](const Asked& asked) -> Answer { return response("tptz:GetNodes", of_all_heads(asked, node)); }},
    {"GetNode", [](const Asked& asked) { return of_head(asked, "tptz:GetNode", "NodeToken", "NoEntity", node); }},
    {"GetConfigurations",
     [](const Asked& asked) -> Answer {
         return response("tptz:GetConfigurations", of_all_heads(asked, configuration));
     }},
    {"GetConfiguration",
     [](const Asked& asked) {
         return of_head(asked, "tptz:GetConfiguration", "PTZConfigurationToken", "NoConfig", configuration);
     }},
    {"GetCompatibleConfigurations",
     [](const Asked& asked) {
         return of_head(asked, "tptz:GetCompatibleConfigurations", "ProfileToken", "NoProfile", configuration);
     }},
    {"GetConfigurationOptions",
     [](const Asked& asked) {
         return of_head(asked, "tptz:GetConfigurationOptions", "ConfigurationToken", "NoConfig", configuration_options);
     }},
    {"GetStatus", nullptr, Access::read_media, get, status_reply},
    {"GetPresets", nullptr, Access::read_media, get, presets_reply},
    {"AbsoluteMove", nullptr, Access::actuate, absolute_move, empty_reply<absolute_name>},
    {"RelativeMove", nullptr, Access::actuate, relative_move, empty_reply<relative_name>},
    {"ContinuousMove", nullptr, Access::actuate, continuous_move, empty_reply<continuous_name>},
    {"Stop", nullptr, Access::actuate, stop, empty_reply<stop_name>},
    {"SendAuxiliaryCommand", nullptr, Access::actuate, auxiliary, auxiliary_reply},
    {"SetPreset", nullptr, Access::actuate, set_preset, set_preset_reply},
    {"GotoPreset", nullptr, Access::actuate, goto_preset, empty_reply<goto_name>},
    {"RemovePreset", nullptr, Access::actuate, remove_preset, empty_reply<remove_name>},
    {"GotoHomePosition", nullptr, Access::actuate, go_home, empty_reply<go_home_name>},
    {"SetHomePosition", nullptr, Access::actuate, set_home, empty_reply<set_home_name>},
};

}  // namespace

Service ptz_service() {
    return {"http://www.onvif.org/ver20/ptz/wsdl", operations};
}

}  // namespace camrig::onvif
