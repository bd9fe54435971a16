#include "control/rpc/generated_files.h"
#include "control/rpc/method_fields.h"
#include "control/rpc/methods.h"

namespace camrig::control {
namespace {

using nlohmann::json;

constexpr double max_step_s = 24 * 3600.0;
constexpr double max_timeout_s = 3600.0;
constexpr const char* scene_doc =
    "name of a shipped scene (hall, street, crowd, clock, calibration, minimal), or path of a scene file or a bare "
    ".gltf/.glb, from the rig's working directory";

const std::vector<FieldOf<engine::WorldState>>& world_fields() {
    using State = engine::WorldState;
    static const std::vector<FieldOf<State>> table{
        told_at<&State::scene>({.name = "scene", .doc = "name of the scene"}),
        told_at<&State::scene_file>({.name = "scene_file", .doc = "the file it came from"}),
        told_at<&State::mode>({.name = "mode"}),
        told_at<&State::overload>({.name = "overload"}),
        told_at<&State::quality>({.name = "quality", .doc = "the rig's own"}),
        told_at<&State::paused>({.name = "paused", .doc = "world time stands still (realtime)"}),
        told_at<&State::world_ns>({.name = "world_ns", .doc = "world time", .unit = "ns"}),
        told_at<&State::step_ns>({.name = "step_ns", .doc = "the world's own step", .unit = "ns"}),
        told_at<&State::seed>({.name = "seed", .doc = "seed of all chance in the world", .range = {.low = 0}}),
        {.field = {.name = "state_ns", .type = "integer", .doc = "world time of the last step", .unit = "ns"},
         .write = [](const State& state) { return json(state.state.world_ns); }},
        {.field = {.name = "state_hash",
                   .type = "string",
                   .doc = "of all that decides the world's future, at state_ns: equal states have equal hashes"},
         .write = [](const State& state) { return json(hex_text(state.state.value)); }},
        told_at<&State::objects>({.name = "objects", .doc = "objects of the scene"}),
        told_at<&State::actors>({.name = "actors", .doc = "actors that are there now"}),
        told_at<&State::cameras>({.name = "cameras", .doc = "cameras of the rig"}),
        told_at<&State::places>(
            {.name = "places", .type = "array of strings", .doc = "named camera places of the scene"}),
        told_at<&State::applied_ns>(
            {.name = "applied_ns", .doc = "world time from which this state holds", .unit = "ns"})};
    return table;
}

}  // namespace

std::vector<Field> world_descriptions() {
    return descriptions_of(world_fields());
}

namespace {

json world_json(const engine::WorldState& state) {
    return write_fields(world_fields(), state);
}

const std::vector<FieldOf<engine::StepWorld>>& step_fields() {
    static const std::vector<FieldOf<engine::StepWorld>> table{
        // The nearest nanosecond: 0.2 s is 200000000 ns, as it reads.
        world::seconds_at<&engine::StepWorld::duration_ns>(
            {.name = "seconds", .doc = "how far, taken to the nearest nanosecond", .range = {0.0, max_step_s}}),
        world::entry_by<&engine::StepWorld::duration_ns>(
            {.name = "nanoseconds",
             .type = "integer",
             .doc = "how far, exactly",
             .unit = "ns",
             .range = {0.0, max_step_s * 1e9}},
            [](JsonReader& reader, std::string_view key, TimeNs& out) { reader.required(key, out); }),
        world::seconds_at<&engine::StepWorld::timeout_ns>(
            {.name = "timeout_s",
             .doc = "longest wait for the readers of one instant",
             .fallback = "10",
             .range = {.low = 0.0, .high = max_timeout_s, .is_low_out = true}})};
    return table;
}

Result<engine::StepWorld> read_step(JsonReader& reader) {
    return read_all<engine::StepWorld>(step_fields(), reader, [](const engine::StepWorld&, JsonReader& keys) {
        if (keys.has("seconds") == keys.has("nanoseconds"))
            keys.fail({ErrorKind::invalid_argument, "world.step: give either seconds or nanoseconds"});
    });
}

std::string read_scene_name(JsonReader& reader) {
    std::string file;
    reader.required("scene", file);
    if (reader.ok() && file.find('\0') != std::string::npos) reader.fail("scene", "a path holds no zero byte");
    return file;
}

/// Reading files and decoding pictures has a thread of its own; the engine gets the finished scene.
void post_reading(RpcContext& context, const RpcReply& done, std::function<void()> job) {
    if (context.loader->post(std::move(job))) return;
    done(error(ErrorKind::resource_exhausted,
               std::to_string(max_scenes_waiting) + " scenes wait to be read already; ask again later"));
}

void load(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    const std::string file = read_scene_name(reader);
    world::SceneOptions options;
    reader.optional("ground", options.bare_ground);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    post_reading(context, done, [&context, file, options, done] {
        auto scene = load_scene(file, options);
        if (!scene) return done(std::unexpected(scene.error()));
        post(context, engine::LoadWorld{std::move(*scene)}, done, world_json);
    });
}

void check(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    const std::string file = read_scene_name(reader);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    post_reading(context, done, [file, done] { done(RpcResult(to_json(world::check_scene(file)))); });
}

}  // namespace

json to_json(const world::SceneCheck& check) {
    json errors = json::array();
    for (const PlacedError& each : check.errors)
        errors.push_back({{"file", check.file.string()}, {"path", each.path}, {"message", each.message}});
    return {{"scene_file", check.file.string()}, {"errors", std::move(errors)}, {"left_out", check.left_out}};
}

std::vector<Method> world_methods(RpcContext& context) {
    using enum ErrorKind;
    return {
        {.name = "world.load",
         .summary =
             "Loads another scene. World time starts again at 0; cameras stay, those of the scene are added unless "
             "their names are taken. The files are read first, so commands sent before the answer may be applied "
             "to the old scene. Errors name the file and the JSON path; nothing changes then.",
         .params = {{"scene", "string", scene_doc, true},
                    {"ground", "boolean", "a bare .gltf/.glb stands on a ground under a sky", false, "", "true"}},
         .result = world_descriptions(),
         .errors = {invalid_argument, not_found, unsupported, resource_exhausted, unavailable},
         .handler = [&context](const json& params, RpcReply done) { load(context, params, std::move(done)); },
         .example = R"({"scene": "scenes/minimal.json"})",
         .reads_files = true},
        {.name = "scene.check",
         .summary = "Reads a scene as world.load does, but on after errors, and tells all of them; nothing is loaded "
                    "into the world. No errors: the scene is good.",
         .params = {{"scene", "string", scene_doc, true}},
         .result = {{"scene_file", "string", "the file that was read"},
                    {"errors", "array of {file, path, message}",
                     "at most 100: where (JSON path; empty: the file as a whole), what is wrong, what would be right"},
                    {"left_out", "integer", "errors beyond those"}},
         .errors = {invalid_argument, resource_exhausted, unavailable},
         .handler = [&context](const json& params, RpcReply done) { check(context, params, std::move(done)); },
         .example = R"({"scene": "hall"})",
         .reads_files = true},
        {.name = "world.status",
         .summary = "What the world is doing.",
         .params = {},
         .result = world_descriptions(),
         .errors = {},
         .handler = handler_of<engine::GetWorld>(context, world_json),
         .only_looks = true},
        {.name = "world.pause",
         .summary = "Holds world time (realtime only).",
         .params = {},
         .result = world_descriptions(),
         .errors = {unsupported},
         .handler = handler_of<engine::PauseWorld>(context, world_json)},
        {.name = "world.resume",
         .summary = "Lets world time run again (realtime only).",
         .params = {},
         .result = world_descriptions(),
         .errors = {unsupported, unavailable},
         .handler = handler_of<engine::ResumeWorld>(context, world_json)},
        {.name = "world.step",
         .summary =
             "Moves the world (lockstep, or paused realtime) and answers when every connected reader was sent every "
             "due frame. A reader that holds it up longer than timeout_s is named in the error. Give either "
             "seconds or nanoseconds.",
         .params = descriptions_of(step_fields()),
         .result = world_descriptions(),
         .errors = {invalid_argument, unavailable, resource_exhausted},
         .handler = handler_of(context, read_step, world_json),
         .example = R"({"seconds": 0.2, "timeout_s": 5})"},
    };
}

}  // namespace camrig::control
