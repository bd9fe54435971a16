#pragma once

#include <nlohmann/json.hpp>

#include "core/base/field_of.h"
#include "core/base/result.h"
#include "core/world/scene.h"

namespace camrig::world {

inline constexpr std::size_t max_steered_actors = 5000;

FieldTable<Attachment> fields_of(std::type_identity<Attachment>);
/// An object of a scene file.
FieldTable<ObjectSpec> fields_of(std::type_identity<ObjectSpec>);
/// An actor in scene files and in actor.spawn.
FieldTable<ActorSpec> fields_of(std::type_identity<ActorSpec>);
/// actor.set
FieldTable<ActorPatch> fields_of(std::type_identity<ActorPatch>);
/// One of the actors of actor.steer.
FieldTable<SteerSpec> fields_of(std::type_identity<SteerSpec>);
/// What actor.list and the others tell.
FieldTable<ActorReport> fields_of(std::type_identity<ActorReport>);

/// Errors carry the JSON path. Names are not looked up here: check_actor() does that. `reader` is finished.
Result<ActorSpec> read_actor(JsonReader& reader);
Result<ActorPatch> read_actor_patch(JsonReader& reader);
Result<SteerSpec> read_steer(const nlohmann::json& value, const std::string& path);

}  // namespace camrig::world
