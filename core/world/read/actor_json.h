#pragma once

#include <nlohmann/json.hpp>

#include "core/base/field_of.h"
#include "core/base/result.h"
#include "core/world/actor_spec.h"

namespace camrig {

inline constexpr std::size_t max_steered_actors = 5000;

FieldTable<Attachment> fields_of(std::type_identity<Attachment>);
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
Result<SteerSpec> read_steer(const nlohmann::json& value, std::string path);
/// `key`: {"actor": name, "node": name, "position": [x, y, z], "yaw_deg" | "orientation"}; nothing when it is absent.
void read_attachment(JsonReader& reader, std::string_view key, std::optional<Attachment>& out);

}  // namespace camrig
