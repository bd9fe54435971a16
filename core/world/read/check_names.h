#pragma once

#include <map>
#include <set>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/world/read/follow_graph.h"
#include "core/world/scene.h"

/// Whether what specs speak of is there. The same checks serve the scene file, where `path` is the JSON path of the
/// spec, and commands, where it is empty; messages begin with it.
namespace camrig::world {

struct KnownNames {
    const Scene& scene;                         ///< for its models, routes, areas and lights
    std::map<std::string, std::string> actors;  ///< to the name of their model
    std::set<std::string> spawned;              ///< of these, those that only an event brings
    std::set<std::string> objects;
    std::set<std::string> events;
};

/// All that the file itself declares, and the actors that its events spawn.
KnownNames names_of(const Scene& scene);
/// From here on an actor is known that this action spawns.
void add_spawned(const Action& action, KnownNames& names);

Result<void> check_behaviour(const BehaviourSpec& behaviour, const Model& model, const KnownNames& names,
                             const std::string& path);
Result<void> check_attachment(const Attachment& attachment, const KnownNames& names, const std::string& path);
Result<void> check_mount(const Mount& mount, const KnownNames& names, const std::string& path);
Result<void> check_object(const ObjectSpec& object, const KnownNames& names, const std::string& path);
Result<void> check_actor(const ActorSpec& actor, const KnownNames& names, const std::string& path);
Result<void> check_event(const EventSpec& event, const KnownNames& names, const std::string& path);
Result<void> check_action(const Action& action, const KnownNames& names, const std::string& path);

/// The clip of this model, or an error at `path`; an empty name is fine.
Result<void> check_clip(const Model& model, const std::string& clip, const std::string& path);

/// Refuses actors that follow each other in a circle.
Result<void> check_follows(const std::string& actor, FollowGraph& graph, const std::string& path);

/// Refuses events that fire each other in a circle without time between: `event` against all of them.
Result<void> check_event_loop(const EventSpec& event, std::span<const EventSpec> all, const std::string& path);

}  // namespace camrig::world
