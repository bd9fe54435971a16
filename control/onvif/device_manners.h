#pragma once

#include <cstdint>

#include "core/base/field_table.h"
#include "core/base/named.h"
#include "core/world/camera_spec.h"

namespace camrig::onvif {

/// How a device tells whether its head moves.
enum class MoveStatus : std::uint8_t {
    told,   ///< as the standard has it
    none,   ///< not at all, and it says that it does not
    stuck,  ///< once it was told to move it says for ever that it does
};
std::span<const Named<MoveStatus>> names_of(std::type_identity<MoveStatus>);

/// The options of an output {kind: "onvif"}: the camera as an ONVIF device of its own; and where that falls short of
/// the standard as devices in the field do, so that what clients make of it can be seen.
struct OnvifOutput {
    int port = 0;  ///< of TCP
    MoveStatus move_status = MoveStatus::told;
    bool has_relative_fov = true;  ///< moves by field of view
};
FieldTable<OnvifOutput> fields_of(std::type_identity<OnvifOutput>);

/// Those of the camera's output of that port; the defaults where it has none, as a device with every camera.
OnvifOutput manners_of(const world::CameraSpec& camera, std::uint16_t port);

}  // namespace camrig::onvif
