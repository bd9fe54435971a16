#include "control/rpc/method_fields.h"
#include "core/world/read/actor_json.h"
#include "core/world/world_fields.h"

namespace camrig::control {
namespace {

using nlohmann::json;

constexpr const char* shows = "world time from which it shows";
const Field applied_field{"applied_ns", "integer", shows, false, "ns"};

json list_of_actors(const engine::ActorList& list) {
    json actors = json::array();
    for (const auto& actor : list.actors)
        actors.push_back(change_json<world::ActorReport>({actor, list.state.world_ns}));
    return {
        {"actors", std::move(actors)}, {"state_ns", list.state.world_ns}, {"state_hash", hex_text(list.state.value)}};
}

/// The command that has only this member, read by `read`.
template <typename C, auto member, typename Read>
auto reading(Read read) {
    return [read](JsonReader& reader) -> Result<C> {
        auto value = read(reader);
        if (!value) return std::unexpected(value.error());
        C command;
        command.*member = std::move(*value);
        return command;
    };
}

}  // namespace

std::vector<Method> actor_methods(RpcContext& context) {
    using enum ErrorKind;
    const std::vector<FieldOf<engine::SteerActors>> steer{world::list_at<&engine::SteerActors::actors>(
        {.name = "actors",
         .doc = "each {name, velocity: [x, y, z] m/s, or position: [x, y, z] reached after `seconds` (default 0: at "
                "once), yaw_deg (default: the way it moves), clip}",
         .parts = descriptions_of<world::SteerSpec>()},
        world::max_steered_actors, world::read_steer)};
    return {
        {.name = "actor.list",
         .summary = "All actors, in the order they came, at the world's last step.",
         .params = {},
         .result = {{"actors", "array of objects", "each as actor.spawn gives it"},
                    {"state_ns", "integer", "world time of the last step", false, "ns"},
                    {"state_hash", "string", "as world.status gives it"}},
         .errors = {},
         .handler = handler_of<engine::ListActors>(context, list_of_actors),
         .only_looks = true},
        {.name = "actor.spawn",
         .summary =
             "Puts an actor into the world. The keys are those of an actor in a scene file (docs/scene-format.md); "
             "models, routes and areas are those of the scene.",
         .params = descriptions_of<world::ActorSpec>(),
         .result = change_fields<world::ActorReport>(shows),
         .errors = {invalid_argument, already_exists, not_found, resource_exhausted},
         .handler = handler_of(context, reading<engine::SpawnActor, &engine::SpawnActor::actor>(world::read_actor),
                               change_json<world::ActorReport>),
         .example =
             R"({"name": "guest", "model": "person_1", "class": "person", "position": [16, 9, 0], )"
             R"("behaviour": {"type": "go_to", "position": [22, 7.2, 0], "clip": "walk", "idle_clip": "wait"}})"},
        {.name = "actor.set",
         .summary =
             "Changes an actor; what is not given stays. Another behaviour begins where the actor is (a vehicle's "
             "on its lane); another position begins the behaviour again from there.",
         .params = descriptions_of<world::ActorPatch>(),
         .result = change_fields<world::ActorReport>(shows),
         .errors = {invalid_argument, not_found},
         .handler = handler_of(context, reading<engine::SetActor, &engine::SetActor::patch>(world::read_actor_patch),
                               change_json<world::ActorReport>),
         .example = R"({"name": "anna", "behaviour": {"type": "stand", "clip": "wait"}})"},
        {.name = "actor.steer",
         .summary = "Moves actors by a program of your own, all or none of them. Each becomes `steered` and keeps its "
                    "velocity until it is told another; in lockstep, one call before each step is a behaviour.",
         .params = descriptions_of(steer),
         .result = {applied_field},
         .errors = {invalid_argument, not_found},
         .handler = handler_of(context, steer, applied_json),
         .example = R"({"actors": [{"name": "anna", "velocity": [1.2, 0, 0], "clip": "walk"}]})"},
        remove_method<engine::RemoveActor>(context, "actor",
                                           "Takes an actor out of the world; what it carries is put down.", "anna"),
    };
}

}  // namespace camrig::control
