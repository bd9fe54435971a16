#include <cmath>

#include "control/rpc/check_json.h"
#include "control/rpc/methods.h"
#include "core/base/json_reader.h"

namespace camrig {
namespace {

using nlohmann::json;

constexpr double max_step_s = 24 * 3600.0;
constexpr double max_timeout_s = 3600.0;
constexpr const char* scene_doc =
    "name of a shipped scene (hall, street, crowd, clock, calibration, minimal), or path of a scene file or a bare "
    ".gltf/.glb, from the rig's working directory";

std::vector<Field> world_fields() {
    return {{"scene", "string", "name of the scene"},
            {"scene_file", "string", "the file it came from"},
            {"mode", "string", "`realtime` or `lockstep`"},
            {"overload", "string", "`drop` or `slow`"},
            {"quality", "string", "the rig's own: `fast`, `simple` or `beautiful`"},
            {"paused", "boolean", "world time stands still (realtime)"},
            {"world_ns", "integer", "world time", false, "ns"},
            {"step_ns", "integer", "the world's own step", false, "ns"},
            {"seed", "integer", "seed of all chance in the world"},
            {"state_ns", "integer", "world time of the last step", false, "ns"},
            {"state_hash", "string", "of the actors and lights at state_ns: equal states have equal hashes"},
            {"objects", "integer", "objects of the scene"},
            {"actors", "integer", "actors that are there now"},
            {"cameras", "integer", "cameras of the rig"},
            {"places", "array of strings", "named camera places of the scene"},
            {"applied_ns", "integer", "world time from which this state holds", false, "ns"}};
}

json world_json(const WorldState& state) {
    return to_json(state);
}

template <typename C>
auto simple(RpcContext& context) {
    return [&context](const json&, RpcReply done) { post(context, C{}, std::move(done), world_json); };
}

void step(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    std::optional<double> seconds;
    std::optional<std::int64_t> nanoseconds;
    double timeout_s = 10.0;
    reader.optional("seconds", seconds);
    reader.optional("nanoseconds", nanoseconds);
    reader.optional("timeout_s", timeout_s);
    if (reader.ok() && seconds.has_value() == nanoseconds.has_value())
        reader.fail({ErrorKind::invalid_argument, "world.step: give either seconds or nanoseconds"});
    StepWorld command;
    if (seconds) {
        if (!(*seconds >= 0.0 && *seconds <= max_step_s)) reader.fail("seconds", "must be from 0 to 86400");
        // The nearest nanosecond: 0.2 s is 200000000 ns, as it reads.
        if (reader.ok()) command.duration_ns = std::llround(*seconds * 1e9);
    } else if (nanoseconds) {
        command.duration_ns = *nanoseconds;
        if (*nanoseconds < 0 || *nanoseconds > static_cast<TimeNs>(max_step_s) * ns_per_s)
            reader.fail("nanoseconds", "must be from 0 to 86400000000000: 0 to 86400 seconds");
    }
    if (!(timeout_s > 0.0 && timeout_s <= max_timeout_s)) reader.fail("timeout_s", "must be above 0 and at most 3600");
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    command.timeout_ns = std::llround(timeout_s * 1e9);
    post(context, command, std::move(done), world_json);
}

std::string read_scene_name(JsonReader& reader) {
    std::string file;
    reader.required("scene", file);
    if (reader.ok() && file.find('\0') != std::string::npos) reader.fail("scene", "a path holds no zero byte");
    return file;
}

/// Reading files and decoding pictures has a thread of its own; the engine gets the finished scene.
void post_reading(RpcContext& context, const RpcReply& done, std::function<void()> job) {
    if (context.loader->post(job)) return;
    done(error(ErrorKind::resource_exhausted,
               std::to_string(max_scenes_waiting) + " scenes wait to be read already; ask again later"));
}

void load(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    const std::string file = read_scene_name(reader);
    SceneOptions options;
    reader.optional("ground", options.bare_ground);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    post_reading(context, done, [&context, file, options, done] {
        auto scene = load_scene(file, options);
        if (!scene) return done(std::unexpected(scene.error()));
        post(context, LoadWorld{std::move(*scene)}, done, world_json);
    });
}

void check(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    const std::string file = read_scene_name(reader);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    post_reading(context, done, [file, done] { done(RpcResult(to_json(check_scene(file)))); });
}

}  // namespace

json to_json(const SceneCheck& check) {
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
         .result = world_fields(),
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
         .result = world_fields(),
         .errors = {},
         .handler = simple<GetWorld>(context),
         .only_looks = true},
        {.name = "world.pause",
         .summary = "Holds world time (realtime only).",
         .params = {},
         .result = world_fields(),
         .errors = {unsupported},
         .handler = simple<PauseWorld>(context)},
        {.name = "world.resume",
         .summary = "Lets world time run again (realtime only).",
         .params = {},
         .result = world_fields(),
         .errors = {unsupported, unavailable},
         .handler = simple<ResumeWorld>(context)},
        {.name = "world.step",
         .summary =
             "Moves the world (lockstep, or paused realtime) and answers when every connected reader was sent every "
             "due frame. A reader that holds it up longer than timeout_s is named in the error. Give either "
             "seconds or nanoseconds.",
         .params = {{"seconds", "number", "how far, 0 to 86400; taken to the nearest nanosecond", false, "s"},
                    {"nanoseconds", "integer", "how far, exactly", false, "ns"},
                    {"timeout_s", "number", "longest wait for the readers of one instant, up to 3600", false, "s",
                     "10"}},
         .result = world_fields(),
         .errors = {invalid_argument, unavailable, resource_exhausted},
         .handler = [&context](const json& params, RpcReply done) { step(context, params, std::move(done)); },
         .example = R"({"seconds": 0.2, "timeout_s": 5})"},
    };
}

}  // namespace camrig
