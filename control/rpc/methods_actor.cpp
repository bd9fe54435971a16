#include "control/rpc/methods.h"
#include "core/world/read/actor_json.h"
#include "core/world/read/world_fields.h"

namespace camrig {
namespace {

using nlohmann::json;

const Field applied_field{"applied_ns", "integer", "world time from which it shows", false, "ns"};

template <typename T>
std::vector<Field> actor_fields() {
    return descriptions_of(fields_of(std::type_identity<T>{}));
}

std::vector<Field> actor_state_fields() {
    std::vector<Field> all = actor_fields<ActorReport>();
    all.push_back(applied_field);
    return all;
}

json actor_change_json(const ActorChange& change) {
    json value = json_of(change.actor);
    value["applied_ns"] = change.applied_ns;
    return value;
}

json list_of_actors(const ActorList& list) {
    json actors = json::array();
    for (const auto& actor : list.actors) actors.push_back(actor_change_json({actor, list.state.world_ns}));
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

Result<SteerActors> read_steering(JsonReader& reader) {
    SteerActors command;
    const auto items = reader.array("actors", max_steered_actors);
    for (std::size_t i = 0; i < items.size() && reader.ok(); ++i) {
        if (auto steer = read_steer(items[i], item_path("actors", i)))
            command.actors.push_back(std::move(*steer));
        else
            reader.fail(steer.error());
    }
    if (auto finished = reader.finish(); !finished) return std::unexpected(finished.error());
    return command;
}

}  // namespace

std::vector<Method> actor_methods(RpcContext& context) {
    using enum ErrorKind;
    const std::vector<FieldOf<RemoveActor>> remove{
        name_at<&RemoveActor::name>({.name = "name", .doc = "name of the actor", .required = true})};
    return {
        {.name = "actor.list",
         .summary = "All actors, in the order they came, at the world's last step.",
         .params = {},
         .result = {{"actors", "array of objects", "each as actor.spawn gives it"},
                    {"state_ns", "integer", "world time of the last step", false, "ns"},
                    {"state_hash", "string", "as world.status gives it"}},
         .errors = {},
         .handler = handler_of<ListActors>(context, list_of_actors),
         .only_looks = true},
        {.name = "actor.spawn",
         .summary =
             "Puts an actor into the world. The keys are those of an actor in a scene file (docs/scene-format.md); "
             "models, routes and areas are those of the scene.",
         .params = actor_fields<ActorSpec>(),
         .result = actor_state_fields(),
         .errors = {invalid_argument, already_exists, not_found, resource_exhausted},
         .handler = handler_of(context, reading<SpawnActor, &SpawnActor::actor>(read_actor), actor_change_json),
         .example =
             R"({"name": "guest", "model": "person_1", "class": "person", "position": [16, 9, 0], )"
             R"("behaviour": {"type": "go_to", "position": [22, 7.2, 0], "clip": "walk", "idle_clip": "wait"}})"},
        {.name = "actor.set",
         .summary =
             "Changes an actor; what is not given stays. Another behaviour begins where the actor is (a vehicle's "
             "on its lane); another position begins the behaviour again from there.",
         .params = actor_fields<ActorPatch>(),
         .result = actor_state_fields(),
         .errors = {invalid_argument, not_found},
         .handler = handler_of(context, reading<SetActor, &SetActor::patch>(read_actor_patch), actor_change_json),
         .example = R"({"name": "anna", "behaviour": {"type": "stand", "clip": "wait"}})"},
        {.name = "actor.steer",
         .summary = "Moves actors by a program of your own, all or none of them. Each becomes `steered` and keeps its "
                    "velocity until it is told another; in lockstep, one call before each step is a behaviour.",
         .params = {{.name = "actors",
                     .type = "array of objects",
                     .doc = "each {name, velocity: [x, y, z] m/s, or position: [x, y, z] reached after `seconds` "
                            "(default 0: at once), yaw_deg (default: the way it moves), clip}",
                     .parts = actor_fields<SteerSpec>()}},
         .result = {applied_field},
         .errors = {invalid_argument, not_found},
         .handler = handler_of(context, read_steering, applied_json),
         .example = R"({"actors": [{"name": "anna", "velocity": [1.2, 0, 0], "clip": "walk"}]})"},
        {.name = "actor.remove",
         .summary = "Takes an actor out of the world; what it carries is put down.",
         .params = descriptions_of(remove),
         .result = {applied_field},
         .errors = {invalid_argument, not_found},
         .handler = handler_of(context, remove, applied_json),
         .example = R"({"name": "anna"})"},
    };
}

}  // namespace camrig
