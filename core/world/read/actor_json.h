#pragma once

#include <nlohmann/json.hpp>

#include "core/base/json_reader.h"
#include "core/base/result.h"
#include "core/world/actor_spec.h"

namespace camrig {

inline constexpr std::size_t max_steered_actors = 5000;

/// The keys of an actor, in scene files and in actor.spawn; errors carry the JSON path. Names are not looked up here:
/// check_actor() does that. `reader` is finished.
Result<ActorSpec> read_actor(JsonReader& reader);
/// The keys of actor.set.
Result<ActorPatch> read_actor_patch(JsonReader& reader);
/// The keys of one of the actors of actor.steer.
Result<SteerSpec> read_steer(const nlohmann::json& value, std::string path);
/// `key`: {"actor": name, "node": name, "position": [x, y, z], "yaw_deg" | "orientation"}; nothing when it is absent.
void read_attachment(JsonReader& reader, std::string_view key, std::optional<Attachment>& out);

nlohmann::json actor_to_json(const ActorReport& actor);

}  // namespace camrig
