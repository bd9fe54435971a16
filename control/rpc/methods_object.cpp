#include "control/rpc/method_fields.h"
#include "core/truth/posed_object.h"
#include "core/world/read/object_json.h"
#include "core/world/world_fields.h"

namespace camrig::control {
namespace {

using nlohmann::json;

constexpr const char* object_shows = "world time from which it shows";

/// What object.get is asked.
struct ObjectQuestion {
    std::string name;
};

json objects_json(const std::shared_ptr<const engine::HeldInstant>& instant) {
    return {{"objects", list_json(objects_of(*instant->snapshot))}, {"state_ns", instant->snapshot->world_ns}};
}

json vector_json(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

/// The box in the world of what is drawn of it but for what is blended; null: nothing is.
json box_json(const world::Instance& instance) {
    truth::PosedObject posed;
    posed.pose(instance);
    posed.place_vertices();
    glm::dvec3 least(std::numeric_limits<double>::infinity()), most(-least);
    for (const auto& part : posed.parts())
        for (const glm::dvec3& point : part.points) {
            const glm::dvec3 place = posed.position() + posed.orientation() * point;
            least = glm::min(least, place);
            most = glm::max(most, place);
        }
    if (least.x > most.x) return nullptr;
    return {{"min", vector_json(least)}, {"max", vector_json(most)}};
}

Result<RpcResult> object_result(const engine::HeldInstant& instant, const std::string& name) {
    world::ObjectReport report;
    const world::Instance* const found = find_object(*instant.snapshot, name, &report);
    if (!found)
        return error(ErrorKind::not_found,
                     "name: there is no object '" + name.substr(0, 80) + "'; object.list lists them");
    json value = json_of(report);
    value["box"] = box_json(*found);
    value["state_ns"] = instant.snapshot->world_ns;
    return RpcResult(std::move(value));
}

void get_object(RpcContext& context, const std::vector<FieldOf<ObjectQuestion>>& table, const json& params,
                RpcReply done) {
    JsonReader reader(params, "");
    auto asked = read_all(table, reader);
    if (!asked) return done(std::unexpected(asked.error()));
    context.commands.post(engine::Request<engine::GetInstant>{
        {}, [replies = context.replies, done = std::move(done), name = std::move(asked->name)](auto instant) {
            if (!instant) return done(std::unexpected(instant.error()));
            std::function<void()> job = [done, name, held = *instant] {
                done(unless_out_of_memory([&] { return object_result(*held, name); }));
            };
            if (!replies->post(std::move(job))) job();
        }});
}

}  // namespace

std::vector<Method> object_methods(RpcContext& context) {
    using enum ErrorKind;
    const std::vector<FieldOf<ObjectQuestion>> asked{world::name_at<&ObjectQuestion::name>(
        {.name = "name", .doc = "name of the object or actor", .required = true})};
    std::vector<Field> told = descriptions_of<world::ObjectReport>();
    told.push_back({.name = "box",
                    .type = "object or null",
                    .doc = "its box along the world's axes",
                    .unit = "m",
                    .null = "nothing of it is drawn",
                    .parts = {{.name = "min", .type = "[x, y, z]"}, {.name = "max", .type = "[x, y, z]"}},
                    .shape = "Box"});
    told.push_back({"state_ns", "integer", "world time of the last step", false, "ns"});
    const auto read_set = [](JsonReader& reader) -> Result<engine::SetObject> {
        auto patch = read_all<world::ObjectPatch>(reader);
        if (!patch) return std::unexpected(patch.error());
        return engine::SetObject{std::move(*patch)};
    };
    const auto read_spawn = [](JsonReader& reader) -> Result<engine::SpawnObject> {
        auto object = read_all(world::spawned_object_fields(), reader);
        if (!object) return std::unexpected(object.error());
        return engine::SpawnObject{std::move(*object)};
    };
    return {
        {.name = "object.list",
         .summary = "Everything that has an identity in pictures: objects that stand, and all that moves, actors too, "
                    "by id, at the world's last step.",
         .params = {},
         .result = {{"objects", "array of objects", "each as object.set gives it"},
                    {"state_ns", "integer", "world time of the last step", false, "ns"}},
         .errors = {},
         .handler = handler_of<engine::GetInstant>(context, objects_json),
         .only_looks = true},
        {.name = "object.get",
         .summary = "One of them, with its box.",
         .params = descriptions_of(asked),
         .result = std::move(told),
         .errors = {invalid_argument, not_found},
         .handler = [&context, asked](const json& params,
                                      RpcReply done) { get_object(context, asked, params, std::move(done)); },
         .example = R"({"name": "table"})",
         .only_looks = true},
        {.name = "object.spawn",
         .summary =
             "Puts an object into the world, which stands where it is. The keys are those of an object in a scene "
             "file (docs/scene-format.md) but for `attach`; models are those of the scene. What is to move is "
             "an actor: actor.spawn.",
         .params = descriptions_of(world::spawned_object_fields()),
         .result = change_fields<world::ObjectReport>(object_shows),
         .errors = {invalid_argument, already_exists, not_found, resource_exhausted},
         .handler = handler_of(context, read_spawn, change_json<world::ObjectReport>),
         .example = R"({"name": "box_2", "model": "box", "position": [3, 2, 0]})"},
        {.name = "object.set",
         .summary = "Hides, shows, scales an object or an actor, or moves an object; what is not given stays.",
         .params = descriptions_of<world::ObjectPatch>(),
         .result = change_fields<world::ObjectReport>(object_shows),
         .errors = {invalid_argument, not_found},
         .handler = handler_of(context, read_set, change_json<world::ObjectReport>),
         .example = R"({"name": "table", "hidden": true})"},
        remove_method<engine::RemoveObject>(context, "object", "Takes an object out of the world.", "table"),
    };
}

}  // namespace camrig::control
