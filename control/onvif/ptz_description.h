#pragma once

#include <string>
#include <string_view>

#include "core/camera/ptz_status.h"
#include "core/world/camera_spec.h"

/// Markup of what a head can (ONVIF PTZ): its spaces, its node, its configuration.
namespace camrig::onvif {

/// In the order of the schema; clients take the first space of each kind.
std::string ptz_spaces(bool has_fov);
/// What the node has as AuxiliaryCommands.
inline constexpr std::string_view wiper_on = "tt:Wiper|On", wiper_off = "tt:Wiper|Off";
std::string ptz_node(const world::CameraSpec& spec, bool has_fov, std::string_view tag);
/// Of the camera's head, in the generic spaces.
std::string ptz_position(const world::CameraSpec& spec, const camera::PtzPosition& at, std::string_view tag);
std::string ptz_configuration(const world::CameraSpec& spec, std::string_view tag);

}  // namespace camrig::onvif
