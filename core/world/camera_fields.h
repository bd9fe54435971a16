#pragma once

#include <type_traits>

#include "core/base/field_of.h"
#include "core/camera/intrinsics.h"
#include "core/world/camera_spec.h"

/// The parameters of a camera, each described once; docs/decisions/0100 says what is made from them.
namespace camrig::world {

/// In the order in which people are told them; asked for the first time when the families of outputs are registered.
/// `name`, `place` and what only the rig says have no `read` or `write` that does anything: they are not of the spec.
const std::vector<FieldOf<CameraSpec, CameraPatch>>& camera_fields();

FieldTable<Mount> fields_of(std::type_identity<Mount>);
/// position, look_at, the angles and orientation; read_pose reads them.
const std::vector<Field>& pose_fields();
/// model and coefficients; read_lens_model reads them.
const std::vector<Field>& lens_model_fields();

}  // namespace camrig::world
