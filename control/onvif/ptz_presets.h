#pragma once

#include <string>
#include <vector>

#include "control/onvif/operation.h"

/// Presets and home of ONVIF PTZ. A preset's token is its name, which all clients of the rig share.
namespace camrig::onvif {

/// What a head is told; in this order, at least one.
using Orders = Answered<std::vector<PtzCommand>>;

/// The camera of an operation on a head.
inline const std::string& name_of(const Asked& asked) {
    return asked.cameras.front()->name;
}

/// Of one without a name and a token: the first whole number that is free. PresetExist, NoToken, InvalidPresetName,
/// TooManyPresets.
Orders set_preset(const Asked& asked);
Orders goto_preset(const Asked& asked);
Orders remove_preset(const Asked& asked);
Orders go_home(const Asked& asked);
Orders set_home(const Asked& asked);

std::string presets_reply(const Asked& asked, const engine::PtzReply& told);
std::string set_preset_reply(const Asked& asked, const engine::PtzReply& told);

}  // namespace camrig::onvif
