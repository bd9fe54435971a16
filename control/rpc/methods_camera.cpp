#include "control/rpc/methods.h"
#include "core/base/json_reader.h"
#include "core/base/names.h"
#include "core/world/camera_json.h"

namespace camrig {
namespace {

using nlohmann::json;

const Field name_field{"name", "string", "name of the camera, `[a-z0-9_]{1,24}`", true};

/// What camera.create and camera.set share. In camera.set what is not given stays as it is.
std::vector<Field> camera_fields() {
    return {
        {"size", "[width, height]", "16x16 to 8192x8192", false, "px", "[640, 480]"},
        {"fps", "number or \"num/den\"", "1/10 to 1000", false, "1/s", "25"},
        {"vfov_deg", "number", "vertical field of view, edge to edge; or hfov_deg or intrinsics", false, "deg", "60"},
        {"hfov_deg", "number", "horizontal field of view, edge to edge", false, "deg"},
        {"intrinsics", "object", "see intrinsics", false, "px"},
        {"zoom", "number",
         "1 to 10: scales the focal length; optics are given as they are at the zoom given with them, else at 1", false,
         "", "1"},
        {"pose", "object", "see pose"},
        {"mount", "object or null", "see mount; null: on nothing, where `pose` is in the world", false, "", "null"},
        {"lens", "object", "see lens", false, "", "pinhole"},
        {"antialias", "string",
         "`none`, `msaa4` (four coverage samples), `ssaa2`, `ssaa3`, `ssaa4` (2x2 to 4x4 full samples) or `auto` "
         "(msaa4 "
         "at quality beautiful up to 4 megapixels, else none)",
         false, "", "auto"},
        {"near", "number", "nearest distance drawn", false, "m", "0.05"},
        {"far", "number", "farthest distance drawn; 0: no limit", false, "m", "0"},
        {"quality", "string or null", "`fast`, `simple` or `beautiful`; null: the rig's", false, "", "the rig's"},
        {"controls", "object", "see controls; what is not given in it stays"},
        {"code_strip", "boolean", "draws camera number, sequence and world time into the picture", false, "", "false"},
        {"outputs", "array of objects", "at most 16, see outputs", false, "", "[]"},
        {"id", "integer", "as camera.get answers; does nothing, like the next three"},
        {"sequence", "integer", "does nothing"},
        {"readers", "integer", "does nothing"},
        {"applied_ns", "integer", "does nothing", false, "ns"},
        {"world_pose", "object", "does nothing"}};
}

std::vector<Field> state_fields() {
    return {
        {"name", "string", "its name"},
        {"size", "[width, height]", "size of its pictures", false, "px"},
        {"fps", "number or \"num/den\"", "its rate", false, "1/s"},
        {"vfov_deg", "number", "vertical field of view", false, "deg"},
        {"hfov_deg", "number", "horizontal field of view", false, "deg"},
        {"intrinsics", "object", "fx, fy, cx, cy as they follow from the above and zoom", false, "px"},
        {"zoom", "number", "in the fields of view and intrinsics already"},
        {"pose", "object", "position, orientation, pan_deg, tilt_deg and roll_deg; in the frame of its mount, if any"},
        {"mount", "object or null", "see mount"},
        {"world_pose", "object", "where it is in the world, as pose; of a mounted camera, at its latest due frame"},
        {"lens", "object", "see lens"},
        {"antialias", "string", "samples per pixel"},
        {"near", "number", "nearest distance drawn", false, "m"},
        {"far", "number", "farthest distance drawn; 0: no limit", false, "m"},
        {"quality", "string or null", "null: the rig's"},
        {"controls", "object", "all of them"},
        {"code_strip", "boolean", "whether its pictures carry one"},
        {"outputs", "array of objects", "as they were asked for"},
        {"id", "integer", "one life of a camera; never used again"},
        {"sequence", "integer", "number of its latest due frame"},
        {"readers", "integer", "how many watch it now"},
        {"applied_ns", "integer", "world time from which this state shows", false, "ns"}};
}

std::vector<Field> with(std::vector<Field> head, std::vector<Field> tail) {
    head.insert(head.end(), tail.begin(), tail.end());
    return head;
}

Result<std::string> read_name(const json& params) {
    JsonReader reader(params, "");
    std::string name;
    reader.required("name", name);
    if (reader.ok())
        if (auto good = check_name("name", name); !good) reader.fail(good.error());
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return name;
}

void create(RpcContext& context, const json& params, RpcReply done) {
    CreateCamera command;
    JsonReader reader(params, "");
    reader.required("name", command.name);
    if (reader.ok())
        if (auto good = check_name("name", command.name); !good) reader.fail(good.error());
    reader.optional("place", command.place);
    command.patch = read_camera_patch(reader);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    post(context, std::move(command), std::move(done), [](const CameraState& state) { return to_json(state); });
}

void set(RpcContext& context, const json& params, RpcReply done) {
    SetCamera command;
    JsonReader reader(params, "");
    reader.required("name", command.name);
    command.patch = read_camera_patch(reader);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    post(context, std::move(command), std::move(done), [](const CameraState& state) { return to_json(state); });
}

}  // namespace

std::vector<Method> camera_methods(RpcContext& context) {
    using enum ErrorKind;
    const auto to_json_of_state = [](const CameraState& state) { return to_json(state); };
    return {
        {.name = "camera.create",
         .summary =
             "Makes a camera; its first picture shows the moment it was made. Takes what camera.get answers: fields "
             "of view and angles beside intrinsics and orientation must agree with them, and what else it says "
             "(id, sequence, readers, applied_ns) does nothing.",
         .params =
             with({name_field, {"place", "string", "a place of the scene: its pose and field of view, unless given"}},
                  camera_fields()),
         .result = state_fields(),
         .errors = {invalid_argument, already_exists, not_found, unsupported, resource_exhausted},
         .handler = [&context](const json& params, RpcReply done) { create(context, params, std::move(done)); },
         .example = R"({"name": "lobby", "size": [640, 480], "fps": 25, "vfov_deg": 60, )"
                    R"("pose": {"position": [2, 3, 2.8], "look_at": [12, 9, 1]}, "code_strip": true})"},
        {.name = "camera.set",
         .summary = "Changes a camera; what is not given stays. A new size ends its streams; clients open them again.",
         .params = with({name_field}, camera_fields()),
         .result = state_fields(),
         .errors = {invalid_argument, not_found, unsupported, resource_exhausted},
         .handler = [&context](const json& params, RpcReply done) { set(context, params, std::move(done)); },
         .example =
             R"({"name": "lobby", "fps": "30000/1001", "pose": {"position": [2, 3, 2.8], "pan_deg": 40, "tilt_deg": -10}})"},
        {.name = "camera.delete",
         .summary = "Deletes a camera; its streams end.",
         .params = {name_field},
         .result = {{"applied_ns", "integer", "world time from which it is gone", false, "ns"}},
         .errors = {invalid_argument, not_found},
         .handler =
             [&context](const json& params, RpcReply done) {
                 auto name = read_name(params);
                 if (!name) return done(std::unexpected(name.error()));
                 post(context, DeleteCamera{*name}, std::move(done),
                      [](const Applied& applied) { return json{{"applied_ns", applied.applied_ns}}; });
             },
         .example = R"({"name": "lobby"})"},
        {.name = "camera.get",
         .summary = "Everything about one camera.",
         .params = {name_field},
         .result = state_fields(),
         .errors = {invalid_argument, not_found},
         .handler =
             [&context, to_json_of_state](const json& params, RpcReply done) {
                 auto name = read_name(params);
                 if (!name) return done(std::unexpected(name.error()));
                 post(context, GetCamera{*name}, std::move(done), to_json_of_state);
             },
         .example = R"({"name": "lobby"})",
         .only_looks = true},
        {.name = "camera.list",
         .summary = "All cameras, in the order they were made.",
         .params = {},
         .result = {{"cameras", "array of objects", "each as camera.get gives it"}},
         .errors = {},
         .handler =
             [&context](const json&, RpcReply done) {
                 post(context, ListCameras{}, std::move(done), [](const std::vector<CameraState>& states) {
                     json cameras = json::array();
                     for (const auto& state : states) cameras.push_back(to_json(state));
                     return json{{"cameras", std::move(cameras)}};
                 });
             },
         .only_looks = true},
    };
}

}  // namespace camrig
