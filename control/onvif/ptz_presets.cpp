#include "control/onvif/ptz_presets.h"

#include <algorithm>
#include <map>
#include <utility>

#include "control/onvif/ptz_description.h"
#include "control/onvif/ptz_vector.h"
#include "core/camera/ptz_head.h"

namespace camrig::onvif {
namespace {

constexpr std::size_t max_preset_name = 64;
constexpr std::string_view home_preset = "home";  ///< that clients return to; every head has it

Orders preset_order(const Asked& asked, std::string preset, engine::PtzPresets::Action action) {
    return std::vector<PtzCommand>{
        engine::PtzPresets{name_of(asked), std::move(preset), action, speed_of(asked.request.child("Speed"))}};
}

const std::map<std::string, camera::PtzPosition>& presets_of(const Asked& asked) {
    return (*asked.camera->head())->presets();
}

/// The preset that clients know by that token: what XML cannot say of a name they are told as '?'.
std::string preset_of(const Asked& asked, std::string_view token) {
    const auto& presets = presets_of(asked);
    if (presets.contains(std::string(token))) return std::string(token);
    const auto told =
        std::ranges::find_if(presets, [&](const auto& one) { return escaped(one.first) == escaped(token); });
    return told == presets.end() ? std::string(token) : told->first;
}

std::string preset_to_set(const Asked& asked) {
    if (const auto token = asked.request.text("PresetToken"); !token.empty()) return preset_of(asked, token);
    if (const auto name = asked.request.text("PresetName"); !name.empty()) return std::string(name);
    std::size_t free = 1;
    while (presets_of(asked).contains(std::to_string(free))) ++free;
    return std::to_string(free);
}

}  // namespace

Orders set_preset(const Asked& asked) {
    const std::string preset = preset_to_set(asked);
    const bool is_there = presets_of(asked).contains(preset);
    const bool by_token = !asked.request.text("PresetToken").empty();
    if (by_token && !is_there && preset != home_preset)
        return invalid_argument("NoToken", "there is no preset of this token");
    if (!by_token && is_there) return invalid_argument("PresetExist", "there is a preset of this name");
    if (!is_there && (preset.size() > max_preset_name || !is_xml_text(preset)))
        return invalid_argument("InvalidPresetName", "a preset's name is text of at most 64 bytes");
    if (!is_there && presets_of(asked).size() >= camera::PtzHead::max_presets)
        return std::unexpected(Fault{false, "Action", "TooManyPresets", "the head has as many presets as it may have"});
    return preset_order(asked, preset, by_token ? engine::PtzPresets::Action::set : engine::PtzPresets::Action::add);
}

Orders goto_preset(const Asked& asked) {
    const std::string preset = preset_of(asked, asked.request.text("PresetToken"));
    const bool goes_home = preset == home_preset && !presets_of(asked).contains(preset);
    return preset_order(asked, preset,
                        goes_home ? engine::PtzPresets::Action::go_home : engine::PtzPresets::Action::go_to);
}

Orders remove_preset(const Asked& asked) {
    return preset_order(asked, preset_of(asked, asked.request.text("PresetToken")), engine::PtzPresets::Action::remove);
}

Orders go_home(const Asked& asked) {
    return preset_order(asked, {}, engine::PtzPresets::Action::go_home);
}

Orders set_home(const Asked& asked) {
    return preset_order(asked, {}, engine::PtzPresets::Action::set_home);
}

std::string presets_reply(const Asked& asked, const engine::PtzReply& told) {
    const auto preset = [](const std::string& name, const std::string& at) {
        return element("tptz:Preset", text_element("tt:Name", name) + at, "token=\"" + escaped(name) + "\"");
    };
    std::string all;
    if (!told.presets.contains(std::string(home_preset))) all = preset(std::string(home_preset), "");
    for (const auto& [name, at] : told.presets)
        all += preset(name, ptz_position(*asked.cameras.front(), at, "tt:PTZPosition"));
    return response("tptz:GetPresets", all);
}

std::string set_preset_reply(const Asked& asked, const engine::PtzReply&) {
    return response("tptz:SetPreset", text_element("tptz:PresetToken", preset_to_set(asked)));
}

}  // namespace camrig::onvif
