#include "control/rpc/method_fields.h"
#include "control/rpc/methods.h"
#include "core/world/backdrop/backdrop.h"
#include "core/world/camera_fields.h"
#include "core/world/camera_json.h"

namespace camrig::control {
namespace {

using nlohmann::json;

/// How long what camera.set changes takes.
const FieldOf<engine::SetCamera>& seconds_field() {
    static const auto field = world::seconds_at<&engine::SetCamera::duration_ns>(
        {.name = "seconds",
         .doc =
             "world time in which pose and field of view (zoom, focal length) get there; all else is at once, and so "
             "are optics that change more than the focal length",
         .fallback = "0",
         .range = {0, 86'400}});
    return field;
}

/// Of camera.create; camera.set takes all but the place, and `seconds`. What is not given stays as it is there.
std::vector<Field> params_of(bool creates) {
    std::vector<Field> fields = descriptions_of(world::camera_fields());
    if (!creates) {
        std::erase_if(fields, [](const Field& field) { return field.by == Field::By::client; });
        fields.push_back(seconds_field().field);
    }
    for (Field& field : fields)
        if (field.by == Field::By::rig) field.doc = "as camera.get answers; does nothing";
    return fields;
}

std::vector<Field> state_fields() {
    std::vector<Field> fields = descriptions_of(world::camera_fields());
    std::erase_if(fields, [](const Field& field) { return field.by == Field::By::client; });
    return fields;
}

/// A new name must be one; of others it is told that there is no such camera.
Result<engine::CreateCamera> read_create(JsonReader& reader) {
    static const auto name = camera_name_at<&engine::CreateCamera::name>("name");
    Changes<engine::CreateCamera> named;
    name.read(reader, named);
    engine::CreateCamera command;
    named.apply_to(command);
    reader.optional("place", command.place);
    command.patch = world::read_camera_patch(reader);
    if (auto finished = reader.finish(); !finished) return std::unexpected(finished.error());
    // Here, because nobody waits for the thread that handles a backdrop (RpcServer::handle).
    if (auto loaded = world::load_backdrop(command.patch, {}); !loaded) return std::unexpected(loaded.error());
    return command;
}

Result<engine::SetCamera> read_set(JsonReader& reader) {
    Changes<engine::SetCamera> timed;
    seconds_field().read(reader, timed);
    engine::SetCamera command;
    timed.apply_to(command);
    reader.required("name", command.name);
    command.patch = world::read_camera_patch(reader);
    if (auto finished = reader.finish(); !finished) return std::unexpected(finished.error());
    // Here, because nobody waits for the thread that handles a backdrop (RpcServer::handle).
    if (auto loaded = world::load_backdrop(command.patch, {}); !loaded) return std::unexpected(loaded.error());
    return command;
}

json state_json(const engine::CameraReply& state) {
    return to_json(state);
}

json states_json(const std::vector<engine::CameraReply>& states) {
    json cameras = json::array();
    for (const auto& state : states) cameras.push_back(to_json(state));
    return {{"cameras", std::move(cameras)}};
}

}  // namespace

std::vector<Method> camera_methods(RpcContext& context) {
    using enum ErrorKind;
    const std::vector<FieldOf<engine::DeleteCamera>> deleted{camera_name_at<&engine::DeleteCamera::name>("name")};
    const std::vector<FieldOf<engine::GetCamera>> asked{camera_name_at<&engine::GetCamera::name>("name")};
    return {
        {.name = "camera.create",
         .summary =
             "Makes a camera; its first picture shows the moment it was made. Takes what camera.get answers: fields "
             "of view and angles beside intrinsics and orientation must agree with them, and what else it says "
             "(id, sequence, readers, applied_ns) does nothing.",
         .params = params_of(true),
         .result = state_fields(),
         .errors = {invalid_argument, already_exists, not_found, unsupported, resource_exhausted},
         .handler = handler_of(context, read_create, state_json),
         .example = R"({"name": "lobby", "size": [640, 480], "fps": 25, "vfov_deg": 60, )"
                    R"("pose": {"position": [2, 3, 2.8], "look_at": [12, 9, 1]}, "code_strip": true})",
         .reads_files = true},
        {.name = "camera.set",
         .summary =
             "Changes a camera; what is not given stays. A new size ends its streams; clients open them again. With "
             "`seconds` it moves there at even speeds, pan the shorter way round, the focal length by equal "
             "factors; a later command for the same takes its place.",
         .params = params_of(false),
         .result = state_fields(),
         .errors = {invalid_argument, not_found, unsupported, resource_exhausted},
         .handler = handler_of(context, read_set, state_json),
         .example =
             R"({"name": "lobby", "fps": "30000/1001", "pose": {"position": [2, 3, 2.8], "pan_deg": 40, "tilt_deg": -10}})",
         .reads_files = true},
        {.name = "camera.delete",
         .summary = "Deletes a camera; its streams end.",
         .params = descriptions_of(deleted),
         .result = {{"applied_ns", "integer", "world time from which it is gone", false, "ns"}},
         .errors = {invalid_argument, not_found},
         .handler = handler_of(context, deleted, applied_json),
         .example = R"({"name": "lobby"})"},
        {.name = "camera.get",
         .summary =
             "Everything about one camera. Of one that moves, pose, field of view and intrinsics are those of now.",
         .params = descriptions_of(asked),
         .result = state_fields(),
         .errors = {invalid_argument, not_found},
         .handler = handler_of(context, asked, state_json),
         .example = R"({"name": "lobby"})",
         .only_looks = true},
        {.name = "camera.list",
         .summary = "All cameras, in the order they were made.",
         .params = {},
         .result = {{"cameras", "array of objects", "each as camera.get gives it"}},
         .errors = {},
         .handler = handler_of<engine::ListCameras>(context, states_json),
         .only_looks = true},
    };
}

}  // namespace camrig::control
