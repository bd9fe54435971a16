#pragma once

#include "core/base/field_of.h"
#include "core/world/object_report.h"
#include "core/world/scene.h"

namespace camrig::world {

/// What object.spawn takes: as an object of a scene file, but for what it would hang on.
const std::vector<FieldOf<ObjectSpec>>& spawned_object_fields();
/// object.set
FieldTable<ObjectPatch> fields_of(std::type_identity<ObjectPatch>);
/// What object.list and the others tell.
FieldTable<ObjectReport> fields_of(std::type_identity<ObjectReport>);

}  // namespace camrig::world
