#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <utility>

#include "control/onvif/authentication.h"
#include "control/onvif/operation.h"
#include "core/camera/ptz_head.h"

// ONVIF PTZ (ver20). Its x is positive to the right where camrig's pan is positive to the left; y and tilt agree.
// Generic spaces go from -1 to 1 (zoom: 0 to 1) over what the head can; zoom is in equal factors, as heads zoom.
namespace camrig::onvif {
namespace {

using camera::PtzMode;
using camera::PtzSpec;
using world::CameraSpec;

#define CAMRIG_PAN_TILT "http://www.onvif.org/ver10/tptz/PanTiltSpaces/"
#define CAMRIG_ZOOM "http://www.onvif.org/ver10/tptz/ZoomSpaces/"
constexpr std::string_view position_space = CAMRIG_PAN_TILT "PositionGenericSpace";
constexpr std::string_view translation_space = CAMRIG_PAN_TILT "TranslationGenericSpace";
constexpr std::string_view fov_space = CAMRIG_PAN_TILT "TranslationSpaceFov";
constexpr std::string_view velocity_space = CAMRIG_PAN_TILT "VelocityGenericSpace";
constexpr std::string_view speed_space = CAMRIG_PAN_TILT "GenericSpeedSpace";
constexpr std::string_view zoom_position_space = CAMRIG_ZOOM "PositionGenericSpace";
constexpr std::string_view zoom_translation_space = CAMRIG_ZOOM "TranslationGenericSpace";
constexpr std::string_view zoom_velocity_space = CAMRIG_ZOOM "VelocityGenericSpace";
constexpr std::string_view zoom_speed_space = CAMRIG_ZOOM "ZoomGenericSpeedSpace";
#undef CAMRIG_PAN_TILT
#undef CAMRIG_ZOOM

constexpr TimeNs default_timeout_ns = 10 * ns_per_s;  ///< of a continuous move that names none
constexpr double max_fov = 10.0;                      ///< halves of the picture that a move may go beyond its middle
constexpr double slowest = 0.001;                     ///< share of the head's speed
constexpr std::size_t max_preset_name = 64;
constexpr std::string_view home_preset = "home";  ///< that clients return to; every head has it

/// A generic axis, which goes from -1 to 1.
struct Axis {
    double middle = 0.0, half = 180.0;
    double degrees(double generic) const { return middle + generic * half; }
    /// What middle and half do not give to the last bit at the ends is not beyond the limits.
    double degrees(double generic, const std::optional<camera::PtzLimits>& limits) const {
        const bool is_inside = limits && std::abs(generic) <= 1.0;
        return is_inside ? std::clamp(degrees(generic), limits->low, limits->high) : degrees(generic);
    }
    double generic(double degrees) const { return half > 0.0 ? std::clamp((degrees - middle) / half, -1.0, 1.0) : 0.0; }
};

Axis axis_of(const std::optional<camera::PtzLimits>& limits) {
    if (!limits) return {};
    return {(limits->low + limits->high) / 2, (limits->high - limits->low) / 2};
}

Axis pan_axis(const PtzSpec& spec) {
    Axis axis = axis_of(spec.pan_limits_deg);
    axis.half = -axis.half;
    return axis;
}

double pan_generic(const PtzSpec& spec, double pan_deg) {
    const Axis axis = axis_of(spec.pan_limits_deg);
    return -axis.generic(pan_deg);
}

double zoom_factor(const PtzSpec& spec, double generic) {
    return std::pow(spec.zoom_max, generic);
}

double zoom_generic(const PtzSpec& spec, double zoom) {
    return spec.zoom_max > 1.0 ? std::clamp(std::log(zoom) / std::log(spec.zoom_max), 0.0, 1.0) : 0.0;
}

/// The PanTilt and the Zoom of a vector of a request; what it does not name is empty.
struct Vector {
    std::optional<double> x, y, zoom;
    std::string_view space;  ///< of pan and tilt; empty: the default
};

std::optional<double> number_of(std::optional<std::string_view> text) {
    if (!text) return std::nullopt;
    if (text->starts_with('+')) text->remove_prefix(1);
    double value = 0.0;
    const auto [end, failed] = std::from_chars(text->data(), text->data() + text->size(), value);
    if (failed != std::errc{} || end != text->data() + text->size() || !std::isfinite(value)) return std::nullopt;
    return value;
}

bool is_within(double value, double low, double high) {
    constexpr double rounding = 1e-5;  // of clients that reckon with floats
    return value >= low - rounding && value <= high + rounding;
}

/// What a request's vector may be; `detail` is what a fault says of one that is not.
struct VectorRule {
    std::string_view detail;
    std::string_view space, zoom_space;
    double zoom_low = -1.0;
    bool takes_fov = false;
};

Answered<Vector> read_vector(XmlElement given, const VectorRule& rule) {
    Vector vector;
    const auto refuse = [&](std::string why) { return invalid_argument(rule.detail, std::move(why)); };
    if (const XmlElement turn = given.child("PanTilt")) {
        vector.space = turn.attribute("space").value_or("");
        if (vector.space == rule.space) vector.space = {};
        const bool is_fov = rule.takes_fov && vector.space == fov_space;
        if (!vector.space.empty() && !is_fov)
            return invalid_argument("SpaceNotSupported", "this space is not supported");
        vector.x = number_of(turn.attribute("x"));
        vector.y = number_of(turn.attribute("y"));
        if (!vector.x || !vector.y) return refuse("PanTilt needs x and y, which are numbers");
        const double end = is_fov ? max_fov : 1.0;
        if (!is_within(*vector.x, -end, end) || !is_within(*vector.y, -end, end))
            return refuse("x and y of PanTilt are out of the range of their space");
        vector.x = std::clamp(*vector.x, -end, end);
        vector.y = std::clamp(*vector.y, -end, end);
    }
    if (const XmlElement zoom = given.child("Zoom")) {
        const auto space = zoom.attribute("space").value_or("");
        if (!space.empty() && space != rule.zoom_space)
            return invalid_argument("SpaceNotSupported", "this space is not supported");
        vector.zoom = number_of(zoom.attribute("x"));
        if (!vector.zoom || !is_within(*vector.zoom, rule.zoom_low, 1.0))
            return refuse("Zoom needs x, which is a number in the range of its space");
        vector.zoom = std::clamp(*vector.zoom, rule.zoom_low, 1.0);
    }
    if (!vector.x && !vector.zoom) return refuse("neither PanTilt nor Zoom is named");
    return vector;
}

/// Share of the head's speed: the length of the vector of pan and tilt, else that of zoom. Many clients send zeros
/// where their users chose none.
double speed_of(XmlElement given) {
    const XmlElement turn = given.child("PanTilt");
    double speed =
        std::hypot(number_of(turn.attribute("x")).value_or(0.0), number_of(turn.attribute("y")).value_or(0.0));
    if (!turn) speed = std::abs(number_of(given.child("Zoom").attribute("x")).value_or(0.0));
    return speed > 0.0 ? std::clamp(speed, slowest, 1.0) : 1.0;
}

using Orders = Answered<std::vector<PtzCommand>>;

const std::string& name_of(const Asked& asked) {
    return asked.cameras.front()->name;
}
const PtzSpec& head_of(const Asked& asked) {
    return *asked.cameras.front()->ptz;
}

Orders absolute_move(const Asked& asked) {
    const auto to =
        read_vector(asked.request.child("Position"), {"InvalidPosition", position_space, zoom_position_space, 0.0});
    if (!to) return std::unexpected(to.error());
    const PtzSpec& head = head_of(asked);
    camera::PtzMove move{.mode = PtzMode::absolute, .speed = speed_of(asked.request.child("Speed"))};
    if (to->x) move.pan_deg = pan_axis(head).degrees(*to->x, head.pan_limits_deg);
    if (to->y) move.tilt_deg = axis_of(head.tilt_limits_deg).degrees(*to->y, head.tilt_limits_deg);
    if (to->zoom) move.zoom = std::min(zoom_factor(head, *to->zoom), head.zoom_max);
    return std::vector<PtzCommand>{engine::MovePtz{name_of(asked), move}};
}

Orders relative_move(const Asked& asked) {
    const auto by = read_vector(asked.request.child("Translation"), {.detail = "InvalidTranslation",
                                                                     .space = translation_space,
                                                                     .zoom_space = zoom_translation_space,
                                                                     .takes_fov = true});
    if (!by) return std::unexpected(by.error());
    const PtzSpec& head = head_of(asked);
    camera::PtzMove move{.mode = PtzMode::relative, .speed = speed_of(asked.request.child("Speed"))};
    if (by->zoom) move.zoom = zoom_factor(head, *by->zoom);
    std::vector<PtzCommand> orders;
    if (by->x && by->space == fov_space) {
        orders.emplace_back(engine::AimPtz{name_of(asked), *by->x, *by->y, move.speed});
    } else if (by->x) {
        move.pan_deg = *by->x * pan_axis(head).half;
        move.tilt_deg = *by->y * axis_of(head.tilt_limits_deg).half;
    }
    if (move.pan_deg || move.zoom) orders.emplace_back(engine::MovePtz{name_of(asked), move});
    return orders;
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

Orders get(const Asked& asked) {
    return std::vector<PtzCommand>{engine::GetPtz{name_of(asked)}};
}

Orders preset_order(const Asked& asked, std::string preset, engine::PtzPresets::Action action) {
    return std::vector<PtzCommand>{engine::PtzPresets{name_of(asked), std::move(preset), action}};
}

const std::map<std::string, camera::PtzPosition>& presets_of(const Asked& asked) {
    return (*asked.camera->head())->presets();
}

/// A preset's token is its name, which all clients of the rig share.
std::string preset_to_set(const Asked& asked) {
    if (const auto token = asked.request.text("PresetToken"); !token.empty()) return std::string(token);
    if (const auto name = asked.request.text("PresetName"); !name.empty()) return std::string(name);
    std::size_t free = 1;
    while (presets_of(asked).contains(std::to_string(free))) ++free;
    return std::to_string(free);
}

Orders set_preset(const Asked& asked) {
    const std::string preset = preset_to_set(asked);
    const bool is_there = presets_of(asked).contains(preset);
    const bool by_token = !asked.request.text("PresetToken").empty();
    if (by_token && !is_there && preset != home_preset)
        return invalid_argument("NoToken", "there is no preset of this token");
    if (!by_token && is_there) return invalid_argument("PresetExist", "there is a preset of this name");
    if (preset.size() > max_preset_name || escaped(preset).contains('?'))
        return invalid_argument("InvalidPresetName", "a preset's name is text of at most 64 bytes");
    return preset_order(asked, preset, engine::PtzPresets::Action::set);
}

Orders goto_preset(const Asked& asked) {
    const std::string preset(asked.request.text("PresetToken"));
    const bool goes_home = preset == home_preset && !presets_of(asked).contains(preset);
    return preset_order(asked, preset,
                        goes_home ? engine::PtzPresets::Action::go_home : engine::PtzPresets::Action::go_to);
}

Orders remove_preset(const Asked& asked) {
    return preset_order(asked, std::string(asked.request.text("PresetToken")), engine::PtzPresets::Action::remove);
}

std::string position(const PtzSpec& head, const camera::PtzPosition& at, std::string_view tag) {
    return element(tag, element("tt:PanTilt", "",
                                "x=\"" + number(pan_generic(head, at.pan_deg)) + "\" y=\"" +
                                    number(axis_of(head.tilt_limits_deg).generic(at.tilt_deg)) + "\" space=\"" +
                                    std::string(position_space) + "\"") +
                            element("tt:Zoom", "",
                                    "x=\"" + number(zoom_generic(head, at.zoom)) + "\" space=\"" +
                                        std::string(zoom_position_space) + "\""));
}

std::string status_reply(const Asked& asked, const engine::PtzReply& told) {
    const auto state = [](const char* name, bool is_moving) { return element(name, is_moving ? "MOVING" : "IDLE"); };
    return response(
        "tptz:GetStatus",
        element("tptz:PTZStatus", position(head_of(asked), told.status.position, "tt:Position") +
                                      element("tt:MoveStatus", state("tt:PanTilt", told.status.is_turning) +
                                                                   state("tt:Zoom", told.status.is_zooming)) +
                                      element("tt:UtcTime", text_of_time(asked.utc_ns))));
}

std::string presets_reply(const Asked& asked, const engine::PtzReply& told) {
    const auto preset = [](const std::string& name, const std::string& at) {
        return element("tptz:Preset", text_element("tt:Name", name) + at, "token=\"" + escaped(name) + "\"");
    };
    std::string all;
    if (!told.presets.contains(std::string(home_preset))) all = preset(std::string(home_preset), "");
    for (const auto& [name, at] : told.presets) all += preset(name, position(head_of(asked), at, "tt:PTZPosition"));
    return response("tptz:GetPresets", all);
}

std::string set_preset_reply(const Asked& asked, const engine::PtzReply&) {
    return response("tptz:SetPreset", text_element("tptz:PresetToken", preset_to_set(asked)));
}

std::string range(std::string_view name, double low, double high) {
    return element(name, element("tt:Min", number(low)) + element("tt:Max", number(high)));
}

std::string plane(std::string_view tag, std::string_view space) {
    return element(tag, element("tt:URI", space) + range("tt:XRange", -1, 1) + range("tt:YRange", -1, 1));
}

std::string line(std::string_view tag, std::string_view space, double low) {
    return element(tag, element("tt:URI", space) + range("tt:XRange", low, 1));
}

/// In the order of the schema; clients take the first space of each kind.
std::string spaces() {
    return plane("tt:AbsolutePanTiltPositionSpace", position_space) +
           line("tt:AbsoluteZoomPositionSpace", zoom_position_space, 0) +
           plane("tt:RelativePanTiltTranslationSpace", translation_space) +
           plane("tt:RelativePanTiltTranslationSpace", fov_space) +
           line("tt:RelativeZoomTranslationSpace", zoom_translation_space, -1) +
           plane("tt:ContinuousPanTiltVelocitySpace", velocity_space) +
           line("tt:ContinuousZoomVelocitySpace", zoom_velocity_space, -1) +
           line("tt:PanTiltSpeedSpace", speed_space, 0) + line("tt:ZoomSpeedSpace", zoom_speed_space, 0);
}

std::string node(const CameraSpec& spec, std::string_view tag) {
    return element(tag,
                   text_element("tt:Name", spec.name) + element("tt:SupportedPTZSpaces", spaces()) +
                       element("tt:MaximumNumberOfPresets", std::to_string(camera::PtzHead::max_presets)) +
                       "<tt:HomeSupported>true</tt:HomeSupported>",
                   "token=\"" + spec.name + "\" FixedHomePosition=\"false\"");
}

std::string of_all_heads(const Asked& asked, std::string (*make)(const CameraSpec&, std::string_view),
                         std::string_view tag) {
    std::string all;
    for (const CameraSpecRef& spec : asked.cameras)
        if (spec->ptz) all += make(*spec, tag);
    return all;
}

/// The camera with a head that the request's child names.
Answered<CameraSpecRef> head_named(const Asked& asked, std::string_view child, std::string_view detail) {
    auto camera = camera_of(asked, child, detail);
    if (camera && !(*camera)->ptz) return invalid_argument(detail, "this camera has no head that turns");
    return camera;
}

Answer get_node(const Asked& asked) {
    const auto camera = head_named(asked, "NodeToken", "NoEntity");
    if (!camera) return std::unexpected(camera.error());
    return response("tptz:GetNode", node(**camera, "tptz:PTZNode"));
}

Answer get_configuration(const Asked& asked) {
    const auto camera = head_named(asked, "PTZConfigurationToken", "NoConfig");
    if (!camera) return std::unexpected(camera.error());
    return response("tptz:GetConfiguration", ptz_configuration(**camera, "tptz:PTZConfiguration"));
}

Answer get_compatible_configurations(const Asked& asked) {
    const auto camera = head_named(asked, "ProfileToken", "NoProfile");
    if (!camera) return std::unexpected(camera.error());
    return response("tptz:GetCompatibleConfigurations", ptz_configuration(**camera, "tptz:PTZConfiguration"));
}

Answer get_configuration_options(const Asked& asked) {
    const auto camera = head_named(asked, "ConfigurationToken", "NoConfig");
    if (!camera) return std::unexpected(camera.error());
    return response("tptz:GetConfigurationOptions",
                    element("tptz:PTZConfigurationOptions",
                            element("tt:Spaces", spaces()) +
                                "<tt:PTZTimeout><tt:Min>PT0S</tt:Min><tt:Max>PT86400S</tt:Max></tt:PTZTimeout>"));
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
    {"GetServiceCapabilities",
     [](const Asked&) -> Answer {
         // As "true" and not "1": clients whose schema is older than an attribute compare its text.
         return response("tptz:GetServiceCapabilities",
                         R"(<tptz:Capabilities EFlip="false" Reverse="false" GetCompatibleConfigurations="true")"
                         R"( MoveStatus="true" StatusPosition="true"/>)");
     },
     Access::open},
    {"GetNodes",
     [](const Asked& asked) -> Answer { return response("tptz:GetNodes", of_all_heads(asked, node, "tptz:PTZNode")); }},
    {"GetNode", get_node},
    {"GetConfigurations",
     [](const Asked& asked) -> Answer {
         return response("tptz:GetConfigurations", of_all_heads(asked, ptz_configuration, "tptz:PTZConfiguration"));
     }},
    {"GetConfiguration", get_configuration},
    {"GetCompatibleConfigurations", get_compatible_configurations},
    {"GetConfigurationOptions", get_configuration_options},
    {"GetStatus", nullptr, Access::look, get, status_reply},
    {"GetPresets", nullptr, Access::look, get, presets_reply},
    {"AbsoluteMove", nullptr, Access::command, absolute_move, empty_reply<absolute_name>},
    {"RelativeMove", nullptr, Access::command, relative_move, empty_reply<relative_name>},
    {"ContinuousMove", nullptr, Access::command, continuous_move, empty_reply<continuous_name>},
    {"Stop", nullptr, Access::command, stop, empty_reply<stop_name>},
    {"SetPreset", nullptr, Access::command, set_preset, set_preset_reply},
    {"GotoPreset", nullptr, Access::command, goto_preset, empty_reply<goto_name>},
    {"RemovePreset", nullptr, Access::command, remove_preset, empty_reply<remove_name>},
    {"GotoHomePosition", nullptr, Access::command,
     [](const Asked& asked) { return preset_order(asked, {}, engine::PtzPresets::Action::go_home); },
     empty_reply<go_home_name>},
    {"SetHomePosition", nullptr, Access::command,
     [](const Asked& asked) { return preset_order(asked, {}, engine::PtzPresets::Action::set_home); },
     empty_reply<set_home_name>},
};

}  // namespace

std::string ptz_configuration(const CameraSpec& spec, std::string_view tag) {
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

Service ptz_service() {
    return {"http://www.onvif.org/ver20/ptz/wsdl", operations};
}

}  // namespace camrig::onvif
