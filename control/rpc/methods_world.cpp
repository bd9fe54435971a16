#include <atomic>
#include <cmath>
#include <thread>

#include "control/rpc/methods.h"
#include "core/base/json_reader.h"

namespace camrig {
namespace {

using nlohmann::json;

constexpr double max_step_s = 24 * 3600.0;
constexpr double max_timeout_s = 3600.0;

std::vector<Field> world_fields() {
    return {{"scene", "string", "name of the scene"},
            {"scene_file", "string", "the file it came from"},
            {"mode", "string", "realtime | lockstep"},
            {"overload", "string", "drop | slow"},
            {"quality", "string", "default quality of the rig"},
            {"paused", "boolean", "world time stands still (realtime)"},
            {"world_ns", "integer", "world time, ns"},
            {"step_ns", "integer", "the world's own step, ns"},
            {"seed", "integer", "seed of all chance in the world"},
            {"objects", "integer", "static objects of the scene"},
            {"actors", "integer", "actors of the scene"},
            {"cameras", "integer", "cameras of the rig"},
            {"places", "array of strings", "named camera places"},
            {"applied_ns", "integer", "world time from which this state holds, ns"}};
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
            reader.fail("nanoseconds", "must be from 0 to 86400000000000");
    }
    if (!(timeout_s > 0.0 && timeout_s <= max_timeout_s)) reader.fail("timeout_s", "must be above 0 and at most 3600");
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    command.timeout_ns = std::llround(timeout_s * 1e9);
    post(context, command, std::move(done), world_json);
}

/// Loading reads files and decodes pictures, so it has a thread of its own for that while; the engine gets the finished
/// scene.
void load(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    std::string file;
    reader.required("scene", file);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    static std::atomic<int> loading{0};
    constexpr int max_loading = 2;
    if (loading.fetch_add(1) >= max_loading) {
        loading.fetch_sub(1);
        return done(error(ErrorKind::resource_exhausted, "two scenes are being loaded already; wait for one"));
    }
    std::thread([&context, file, done = std::move(done)] {
        auto scene = load_scene(file);
        loading.fetch_sub(1);
        if (!scene) return done(std::unexpected(scene.error()));
        post(context, LoadWorld{std::move(*scene)}, done, world_json);
    }).detach();
}

}  // namespace

std::vector<Method> world_methods(RpcContext& context) {
    using enum ErrorKind;
    return {
        {"world.load",
         "Loads another scene. World time starts again at 0; cameras stay, those of the scene are added.",
         {{"scene", "string", "path of a scene file or a bare .gltf/.glb, as the rig sees it", true}},
         world_fields(),
         {invalid_argument, not_found, resource_exhausted, unavailable},
         [&context](const json& params, RpcReply done) { load(context, params, std::move(done)); }},
        {"world.status", "What the world is doing.", {}, world_fields(), {}, simple<GetWorld>(context)},
        {"world.pause", "Holds world time (realtime).", {}, world_fields(), {unsupported}, simple<PauseWorld>(context)},
        {"world.resume",
         "Lets world time run again (realtime).",
         {},
         world_fields(),
         {unsupported, unavailable},
         simple<ResumeWorld>(context)},
        {"world.step",
         "Moves the world (lockstep, or paused realtime); answers when every connected reader was sent every due "
         "frame.",
         {{"seconds", "number", "how far; taken to the nearest ns"},
          {"nanoseconds", "integer", "how far, exactly"},
          {"timeout_s", "number", "longest wait for the readers of one instant; default 10"}},
         world_fields(),
         {invalid_argument, unavailable, resource_exhausted},
         [&context](const json& params, RpcReply done) { step(context, params, std::move(done)); }},
    };
}

}  // namespace camrig
