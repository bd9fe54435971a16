#include "control/rpc/methods.h"
#include "core/base/json_reader.h"
#include "core/world/read/actor_json.h"
#include "core/world/read/json_parts.h"

namespace camrig {
namespace {

using nlohmann::json;

std::vector<Field> actor_fields() {
    return {{"name", "string", "its name"},
            {"id", "integer", "its identity in ground truth, in all cameras"},
            {"class", "string", "what ground truth calls it"},
            {"model", "string", "of the scene"},
            {"scale", "number", "of the model"},
            {"position", "[x, y, z]", "of its origin, at the world's last step", false, "m"},
            {"orientation", "[x, y, z, w]", "of the actor: its front is +x"},
            {"yaw_deg", "number", "of its front, counter-clockwise from +x", false, "deg"},
            {"velocity", "[x, y, z]", "over the last step", false, "m/s"},
            {"behaviour", "string", "type of its behaviour"},
            {"arrived", "boolean", "whether it has done what its behaviour is to do"},
            {"clip", "string", "the clip it plays; empty: none"},
            {"attached_to", "string", "the actor that it hangs on; empty: none"},
            {"applied_ns", "integer", "world time from which it shows", false, "ns"}};
}

const Field actor_name{"name", "string", "name of the actor", true};
const Field applied_field{"applied_ns", "integer", "world time from which it shows", false, "ns"};

json change_json(const ActorChange& change) {
    json value = actor_to_json(change.actor);
    value["applied_ns"] = change.applied_ns;
    return value;
}

json applied_json(const Applied& done) {
    return {{"applied_ns", done.applied_ns}};
}

void spawn_actor(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    auto actor = read_actor(reader);
    if (!actor) return done(std::unexpected(actor.error()));
    post(context, SpawnActor{std::move(*actor)}, std::move(done), change_json);
}

void set_actor(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    auto patch = read_actor_patch(reader);
    if (!patch) return done(std::unexpected(patch.error()));
    post(context, SetActor{std::move(*patch)}, std::move(done), change_json);
}

void remove_actor(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    RemoveActor command;
    required_name(reader, "name", command.name);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    post(context, std::move(command), std::move(done), applied_json);
}

void steer_actors(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    SteerActors command;
    const auto items = reader.array("actors", max_steered_actors);
    for (std::size_t i = 0; i < items.size() && reader.ok(); ++i) {
        auto steer = read_steer(items[i], item_path("actors", i));
        if (steer)
            command.actors.push_back(std::move(*steer));
        else
            reader.fail(steer.error());
    }
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    post(context, std::move(command), std::move(done), applied_json);
}

}  // namespace

std::vector<Method> actor_methods(RpcContext& context) {
    using enum ErrorKind;
    const Field position{"position", "[x, y, z]", "of its origin; where a route does not place it", false, "m"};
    const Field yaw{"yaw_deg", "number", "where its front looks, counter-clockwise from +x; or orientation", false,
                    "deg"};
    const Field orientation{"orientation", "[x, y, z, w]", "instead of yaw_deg"};
    const Field attach{"attach", "object",
                       "hangs it on a node of another actor: {actor, node, position, yaw_deg or orientation}"};
    return {
        {.name = "actor.list",
         .summary = "All actors, in the order they came, at the world's last step.",
         .params = {},
         .result = {{"actors", "array of objects", "each as actor.spawn gives it"},
                    {"state_ns", "integer", "world time of the last step", false, "ns"},
                    {"state_hash", "string", "as world.status gives it"}},
         .errors = {},
         .handler =
             [&context](const json&, RpcReply done) {
                 post(context, ListActors{}, std::move(done), [](const ActorList& list) {
                     json actors = json::array();
                     for (const auto& actor : list.actors) actors.push_back(change_json({actor, list.state.world_ns}));
                     return json{{"actors", std::move(actors)},
                                 {"state_ns", list.state.world_ns},
                                 {"state_hash", hex_text(list.state.value)}};
                 });
             },
         .only_looks = true},
        {.name = "actor.spawn",
         .summary =
             "Puts an actor into the world. The keys are those of an actor in a scene file (docs/scene-format.md); "
             "models, routes and areas are those of the scene.",
         .params = {actor_name,
                    {"model", "string", "a model of the scene", true},
                    {"class", "string", "what ground truth calls it", false, "", "object"},
                    position,
                    yaw,
                    orientation,
                    {"scale", "number", "1e-6 to 1e6", false, "", "1"},
                    {"radius_m", "number", "of its body, for those who walk round it", false, "m",
                     "0.28 for class person, else 0"},
                    attach,
                    {"behaviour", "object", "as in a scene file", false, "", "{\"type\": \"stand\"}"}},
         .result = actor_fields(),
         .errors = {invalid_argument, already_exists, not_found, resource_exhausted},
         .handler = [&context](const json& params, RpcReply done) { spawn_actor(context, params, std::move(done)); },
         .example =
             R"({"name": "guest", "model": "person_1", "class": "person", "position": [16, 9, 0], )"
             R"("behaviour": {"type": "go_to", "position": [22, 7.2, 0], "clip": "walk", "idle_clip": "wait"}})"},
        {.name = "actor.set",
         .summary =
             "Changes an actor; what is not given stays. Another behaviour begins where the actor is (a vehicle's "
             "on its lane); another position begins the behaviour again from there.",
         .params = {actor_name,
                    position,
                    yaw,
                    orientation,
                    {"behaviour", "object", "as in a scene file"},
                    attach,
                    {"detach", "boolean", "true: no longer hangs on anything", false, "", "false"},
                    {"play", "string", "a clip over the one of the behaviour; empty: no longer"},
                    {"play_speed", "number", "of that clip, 0 to 100", false, "", "1"}},
         .result = actor_fields(),
         .errors = {invalid_argument, not_found},
         .handler = [&context](const json& params, RpcReply done) { set_actor(context, params, std::move(done)); },
         .example = R"({"name": "anna", "behaviour": {"type": "stand", "clip": "wait"}})"},
        {.name = "actor.steer",
         .summary = "Moves actors by a program of your own, all or none of them. Each becomes `steered` and keeps its "
                    "velocity until it is told another; in lockstep, one call before each step is a behaviour.",
         .params =
             {{"actors", "array of objects",
               "each {name, velocity: [x, y, z] m/s, or position: [x, y, z] reached after `seconds` (default 0: at "
               "once), yaw_deg (default: the way it moves), clip}"}},
         .result = {applied_field},
         .errors = {invalid_argument, not_found},
         .handler = [&context](const json& params, RpcReply done) { steer_actors(context, params, std::move(done)); },
         .example = R"({"actors": [{"name": "anna", "velocity": [1.2, 0, 0], "clip": "walk"}]})"},
        {.name = "actor.remove",
         .summary = "Takes an actor out of the world; what it carries is put down.",
         .params = {actor_name},
         .result = {applied_field},
         .errors = {invalid_argument, not_found},
         .handler = [&context](const json& params, RpcReply done) { remove_actor(context, params, std::move(done)); },
         .example = R"({"name": "anna"})"},
    };
}

}  // namespace camrig
