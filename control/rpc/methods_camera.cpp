#include <cmath>

#include "control/rpc/methods.h"
#include "core/base/json_reader.h"
#include "core/base/names.h"
#include "core/world/camera_fields.h"
#include "core/world/camera_json.h"

namespace camrig {
namespace {

using nlohmann::json;

const Field name_field{"name", "string", "name of the camera, `[a-z0-9_]{1,24}`", true};

constexpr double max_motion_s = 86'400;
const Field seconds_field{.name = "seconds",
                          .type = "number",
                          .doc =
                              "world time in which pose and field of view (zoom, focal length) get there; all else is "
                              "at once, and so are optics that change more than the focal length",
                          .unit = "s",
                          .fallback = "0",
                          .range = {0, max_motion_s}};

/// Of camera.create; camera.set takes all but the place, and `seconds`. What is not given stays as it is there.
std::vector<Field> params_of(bool creates) {
    std::vector<Field> fields = descriptions_of(camera_fields());
    if (!creates) {
        std::erase_if(fields, [](const Field& field) { return field.by == Field::By::client; });
        fields.push_back(seconds_field);
    }
    for (Field& field : fields)
        if (field.by == Field::By::rig) field.doc = "as camera.get answers; does nothing";
    return fields;
}

std::vector<Field> state_fields() {
    std::vector<Field> fields = descriptions_of(camera_fields());
    std::erase_if(fields, [](const Field& field) { return field.by == Field::By::client; });
    return fields;
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
    post(context, std::move(command), std::move(done), [](const CameraReply& camera) { return to_json(camera); });
}

void set(RpcContext& context, const json& params, RpcReply done) {
    SetCamera command;
    JsonReader reader(params, "");
    reader.required("name", command.name);
    command.patch = read_camera_patch(reader);
    if (const auto seconds = read_value<double>(reader, seconds_field))
        command.duration_ns = std::llround(*seconds * static_cast<double>(ns_per_s));
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    post(context, std::move(command), std::move(done), [](const CameraReply& camera) { return to_json(camera); });
}

}  // namespace

std::vector<Method> camera_methods(RpcContext& context) {
    using enum ErrorKind;
    const auto to_json_of_report = [](const CameraReply& camera) { return to_json(camera); };
    return {
        {.name = "camera.create",
         .summary =
             "Makes a camera; its first picture shows the moment it was made. Takes what camera.get answers: fields "
             "of view and angles beside intrinsics and orientation must agree with them, and what else it says "
             "(id, sequence, readers, applied_ns, arrives_ns) does nothing.",
         .params = params_of(true),
         .result = state_fields(),
         .errors = {invalid_argument, already_exists, not_found, unsupported, resource_exhausted},
         .handler = [&context](const json& params, RpcReply done) { create(context, params, std::move(done)); },
         .example = R"({"name": "lobby", "size": [640, 480], "fps": 25, "vfov_deg": 60, )"
                    R"("pose": {"position": [2, 3, 2.8], "look_at": [12, 9, 1]}, "code_strip": true})"},
        {.name = "camera.set",
         .summary =
             "Changes a camera; what is not given stays. A new size ends its streams; clients open them again. With "
             "`seconds` it moves there at even speeds, pan the shorter way round, the focal length by equal "
             "factors; a later command for the same takes its place.",
         .params = params_of(false),
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
         .summary =
             "Everything about one camera. Of one that moves, pose, field of view and intrinsics are those of now.",
         .params = {name_field},
         .result = state_fields(),
         .errors = {invalid_argument, not_found},
         .handler =
             [&context, to_json_of_report](const json& params, RpcReply done) {
                 auto name = read_name(params);
                 if (!name) return done(std::unexpected(name.error()));
                 post(context, GetCamera{*name}, std::move(done), to_json_of_report);
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
                 post(context, ListCameras{}, std::move(done), [](const std::vector<CameraReply>& reports) {
                     json cameras = json::array();
                     for (const auto& report : reports) cameras.push_back(to_json(report));
                     return json{{"cameras", std::move(cameras)}};
                 });
             },
         .only_looks = true},
    };
}

}  // namespace camrig
