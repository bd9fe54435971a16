#include "control/rpc/command_log.h"
#include "control/rpc/method_fields.h"
#include "control/rpc/methods.h"
#include "control/rpc/scene_digest.h"
#include "core/base/names.h"

// What makes worlds on several machines one: how far each may run, and whether they are the same.
namespace camrig::control {
namespace {

using nlohmann::json;

json limit_json(const engine::SetLimit::Reply& reply) {
    const bool is_free = reply.limit_ns == max_time_ns;
    return {{"world_ns", reply.world_ns},
            {"limit_ns", is_free ? json(nullptr) : json(reply.limit_ns)},
            {"waiting", reply.waiting}};
}

json digest_json(const engine::GetDigest::Reply& reply) {
    json value = {{"world_ns", reply.world_ns},           {"hash", hex_text(reply.value)},
                  {"state_ns", reply.state_ns},           {"world", hex_text(reply.world.value)},
                  {"cameras", hex_text(reply.cameras)},   {"commands", hex_text(reply.commands)},
                  {"command_count", reply.command_count}, {"parts", json::object()}};
    for (const world::NamedDigest& part : reply.parts) value["parts"][part.name] = hex_text(part.value);
    return value;
}

/// Files are read on the thread for scenes: the engine only says which scene it is.
void identify(RpcContext& context, const json&, RpcReply done) {
    context.commands.post(engine::Request<engine::GetWorld>{
        {}, [&context, done](Result<engine::WorldState> state) {
            if (!state) return done(std::unexpected(state.error()));
            const auto tell = [&context, done, state = std::move(*state)] {
                // A world that is of no file has none to compare.
                const auto scene = state.scene_file.empty() ? SceneDigest{} : digest_of_scene(state.scene_file);
                if (!scene) return done(std::unexpected(scene.error()));
                json identity = context.identity ? context.identity() : json{{"build", ""}, {"mathematics", ""}};
                identity["scene"] = state.scene;
                identity["scene_hash"] = hex_text(scene->value);
                identity["scene_files"] = scene->files;
                identity["seed"] = state.seed;
                identity["step_ns"] = state.step_ns;
                identity["mode"] = to_string(state.mode);
                identity["quality"] = to_string(state.quality);
                done(std::move(identity));
            };
            if (!context.loader->post(tell))
                done(error(ErrorKind::resource_exhausted, "scenes wait to be read already; ask again later"));
        }});
}

/// World time from now on until when the state is taken, while the world runs: all that is due by then is in it.
constexpr TimeNs save_ahead_ns = 50'000'000;

/// The engine says what the state is, and at the same moment how long the log was; another thread copies that.
void save_at(RpcContext& context, TimeNs at_ns, bool runs, const std::string& name, const RpcReply& done) {
    context.commands.post(engine::Request<engine::GetDigest>{
        {},
        [&context, runs, name, done](Result<engine::GetDigest::Reply> digest) {
            if (!digest && !runs && digest.error().kind == ErrorKind::invalid_argument)
                return done(error(ErrorKind::unavailable, "world.step moved the world meanwhile; save again after it"));
            if (!digest) return done(std::unexpected(digest.error()));
            const auto log = context.log();
            if (!log) return done(std::unexpected(log.error()));
            const auto write = [log = *log, name, done, state = SavedState{digest->world_ns, hex_text(digest->value)},
                                count = digest->command_count] {
                const auto file = save_world(log, name, state);
                if (!file) return done(std::unexpected(file.error()));
                done(json{{"file", file->string()},
                          {"world_ns", state.world_ns},
                          {"hash", state.hash},
                          {"command_count", count}});
            };
            if (!context.loader->post(write))
                done(error(ErrorKind::resource_exhausted, "scenes wait to be read already; ask again later"));
        },
        at_ns});
}

void save(RpcContext& context, const json& params, RpcReply done) {
    std::string name;
    JsonReader reader(params, "");
    reader.required("name", name);
    if (auto good = reader.finish(); !good) return done(std::unexpected(good.error()));
    if (auto good = check_name("name", name); !good) return done(std::unexpected(good.error()));
    if (!context.log)
        return done(
            error(ErrorKind::unavailable,
                  "this rig keeps no log of commands, of which a saved world is made; start it with serve --log "
                  "FILE"));
    context.commands.post(engine::Request<engine::GetWorld>{
        {}, [&context, name, done](Result<engine::WorldState> world) {
            if (!world) return done(std::unexpected(world.error()));
            const bool runs = world->mode == engine::RunMode::realtime && !world->paused;
            save_at(context, world->world_ns + (runs ? save_ahead_ns : 0), runs, name, done);
        }});
}

}  // namespace

std::vector<Method> replica_methods(RpcContext& context) {
    using enum ErrorKind;
    const std::vector<FieldOf<engine::SetLimit>> limit{
        field_at<&engine::SetLimit::until_ns>(
            {.name = "until_ns", .doc = "world time up to which the world may run", .unit = "ns", .range = {.low = 0}}),
        field_at<&engine::SetLimit::clock_ns>(
            {.name = "clock_ns",
             .doc =
                 "world time that it is now, where several rigs have one clock: what is skipped counts as held; less "
                 "than 2 ms are made good at 500 ppm",
             .unit = "ns",
             .range = {.low = 0}})};
    const std::vector<FieldOf<engine::GetDigest>> digest{field_at<&engine::GetDigest::with_parts>(
        {.name = "parts", .doc = "with the hash of each actor and camera, to find what differs"})};
    return {
        {.name = "world.limit",
         .summary =
             "How far the world may run (realtime). At the limit it stands until a later one is given, and then "
             "catches up with its clock; frames that were due meanwhile and come no more are dropped for `held`.",
         .params = descriptions_of(limit),
         .result = {{"world_ns", "integer", "world time", false, "ns"},
                    {"limit_ns", "integer or null", "null: there is none", false, "ns"},
                    {"waiting", "integer", "commands that wait for their world time"}},
         .errors = {invalid_argument, unsupported},
         .handler = handler_of(context, limit, limit_json),
         .example = R"({"until_ns": 60000000000})"},
        {.name = "world.digest",
         .summary =
             "Hashes of all that decides the future of this rig at a world time: two rigs of one scene with equal "
             "hashes at one time go on equally, with the same pictures.",
         .params = descriptions_of(digest),
         .result = {{"world_ns", "integer", "world time", false, "ns"},
                    {"hash", "string", "of all of it"},
                    {"state_ns", "integer", "world time of the world's last step", false, "ns"},
                    {"world", "string",
                     "of actors, behaviours, events, objects and lights, as world.status' state_hash"},
                    {"cameras", "string", "of cameras, heads, faults and the numbers of their next frames"},
                    {"commands", "string",
                     "of the commands done, each with its time; in a rig that is held or keeps a log"},
                    {"command_count", "integer", "how many"},
                    {"parts", "object", "with `parts`, hashes by name; else empty"}},
         .errors = {invalid_argument},
         .handler = handler_of(context, digest, digest_json)},
        {.name = "world.save",
         .summary =
             "Saves the world in a file beside the rig's log of commands: the log up to now, and what its state is. "
             "`serve --replay FILE` makes that world again and compares.",
         .params = {{"name", "string", "of the file: LOG.NAME.save; 1 to 24 of a-z, 0-9 and _", true}},
         .result = {{"file", "string", "that was written"},
                    {"world_ns", "integer", "world time of the state", false, "ns"},
                    {"hash", "string", "of the state, as world.digest tells it"},
                    {"command_count", "integer", "commands that are in it"}},
         .errors = {invalid_argument, already_exists, unavailable, resource_exhausted},
         .handler = [&context](const json& params, RpcReply done) { save(context, params, std::move(done)); },
         .example = R"({"name": "before_lunch"})"},
        {.name = "rig.identity",
         .summary = "What has to be equal in rigs that are to hold the same world.",
         .params = {},
         .result = {{"build", "string", "hash of the program"},
                    {"mathematics", "string",
                     "hash of results of the functions that the world uses, on this processor"},
                    {"scene", "string", "name of the scene"},
                    {"scene_hash", "string", "of the scene file and every file that it names"},
                    {"scene_files", "integer", "how many those are"},
                    {"seed", "integer", "seed of all chance in the world"},
                    {"step_ns", "integer", "the world's own step", false, "ns"},
                    {"mode", "string", "realtime or lockstep"},
                    {"quality", "string", "the rig's own"}},
         .errors = {resource_exhausted, not_found},
         .handler = [&context](const json& params, RpcReply done) { identify(context, params, std::move(done)); }},
    };
}

}  // namespace camrig::control
