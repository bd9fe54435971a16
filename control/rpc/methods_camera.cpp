#include "control/rpc/methods.h"
#include "core/base/json_reader.h"
#include "core/base/names.h"
#include "core/world/camera_json.h"

namespace camrig {
namespace {

using nlohmann::json;

const Field name_field{"name", "string", "name of the camera, [a-z0-9_]{1,24}", true};

/// What camera.create and camera.set share.
std::vector<Field> camera_fields() {
    return {{"size", "[width, height]", "pixels, 16x16 to 8192x8192; default 640x480"},
            {"fps", "number or \"num/den\"", "frames per second, 1/10 to 1000; default 25"},
            {"vfov_deg", "number", "vertical field of view, edge to edge, degrees; default 60"},
            {"hfov_deg", "number", "horizontal field of view instead"},
            {"intrinsics", "{fx, fy, cx, cy}", "pixels, instead of a field of view; pixel centres at integers"},
            {"pose", "object",
             "{position: [x, y, z] m, and one of look_at: [x, y, z] | pan_deg, tilt_deg, roll_deg | orientation: [x, "
             "y, z, w]}"},
            {"lens", "{model, coefficients}", "pinhole | plumb_bob | rational_polynomial | equidistant"},
            {"near", "number", "nearest distance drawn, m; default 0.05"},
            {"far", "number", "farthest distance, m; 0: unlimited (default)"},
            {"quality", "string", "fast | simple | beautiful; default: the rig's"},
            {"code_strip", "boolean", "draw camera number, sequence and world time into the picture; default false"},
            {"outputs", "array", "{kind: \"v4l2\"|\"device\"|\"rtsp\"|\"mjpeg\", ...}"}};
}

std::vector<Field> state_fields() {
    auto fields = camera_fields();
    fields.insert(fields.begin(), {"name", "string", "its name"});
    fields.push_back({"id", "integer", "one life of a camera; never used again"});
    fields.push_back({"sequence", "integer", "number of its latest due frame"});
    fields.push_back({"readers", "integer", "who watches now"});
    fields.push_back({"applied_ns", "integer", "world time from which the reply's state shows, ns"});
    return fields;
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
    return {
        {"camera.create",
         "Makes a camera; its first picture shows the moment it was made.",
         with({name_field,
               {"place", "string", "a named place of the scene: its pose and field of view, unless given here"}},
              camera_fields()),
         state_fields(),
         {invalid_argument, already_exists, not_found, resource_exhausted},
         [&context](const json& params, RpcReply done) { create(context, params, std::move(done)); }},
        {"camera.set",
         "Changes a camera; what is not given stays. A new size ends its streams, clients open them again.",
         with({name_field}, camera_fields()),
         state_fields(),
         {invalid_argument, not_found, resource_exhausted},
         [&context](const json& params, RpcReply done) { set(context, params, std::move(done)); }},
        {"camera.delete",
         "Deletes a camera; its streams end.",
         {name_field},
         {{"applied_ns", "integer", "world time from which it is gone, ns"}},
         {invalid_argument, not_found},
         [&context](const json& params, RpcReply done) {
             auto name = read_name(params);
             if (!name) return done(std::unexpected(name.error()));
             post(context, DeleteCamera{*name}, std::move(done),
                  [](const Applied& applied) { return json{{"applied_ns", applied.applied_ns}}; });
         }},
        {"camera.get",
         "Everything about one camera.",
         {name_field},
         state_fields(),
         {invalid_argument, not_found},
         [&context](const json& params, RpcReply done) {
             auto name = read_name(params);
             if (!name) return done(std::unexpected(name.error()));
             post(context, GetCamera{*name}, std::move(done), [](const CameraState& state) { return to_json(state); });
         }},
        {"camera.list",
         "All cameras, in the order they were made.",
         {},
         {{"cameras", "array", "each as camera.get gives it"}},
         {},
         [&context](const json&, RpcReply done) {
             post(context, ListCameras{}, std::move(done), [](const std::vector<CameraState>& states) {
                 json cameras = json::array();
                 for (const auto& state : states) cameras.push_back(to_json(state));
                 return json{{"cameras", std::move(cameras)}};
             });
         }},
    };
}

}  // namespace camrig
