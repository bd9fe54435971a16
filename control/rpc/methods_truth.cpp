#include "control/rpc/methods.h"
#include "core/base/json_reader.h"
#include "core/base/names.h"
#include "core/truth/truth_json.h"

namespace camrig {
namespace {

void get_truth(RpcContext& context, const nlohmann::json& params, RpcReply done) {
    JsonReader reader(params, "");
    GetTruth command;
    reader.required("camera", command.camera);
    reader.optional("min_ns", command.min_ns);
    if (reader.ok())
        if (auto good = check_name("camera", command.camera); !good) reader.fail(good.error());
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    post(context, std::move(command), std::move(done), [](const TruthRef& truth) { return truth_to_json(*truth); });
}

}  // namespace

std::vector<Method> truth_methods(RpcContext& context) {
    using enum ErrorKind;
    return {{.name = "truth.get",
             .summary = "The truth of the camera's latest due frame: every object that it sees or would see if nothing "
                        "stood in front, through its lens, at the frame's instant. docs/truth.md explains the members "
                        "of `objects`.",
             .params = {{"camera", "string", "name of the camera", true},
                        {"min_ns", "integer",
                         "world time the frame must show or be later than; waits up to 10 s for it. 0: from which the "
                         "camera's last "
                         "command shows",
                         false, "ns", "0"}},
             .result = {{"camera", "string", "its name"},
                        {"sequence", "integer", "number of the frame, as in frame.get"},
                        {"time_ns", "integer", "world time it shows", false, "ns"},
                        {"monotonic_ns", "integer", "CLOCK_MONOTONIC time of that instant", false, "ns"},
                        {"size", "[width, height]", "size of the picture", false, "px"},
                        {"intrinsics", "object", "see intrinsics"},
                        {"lens", "object", "see lens"},
                        {"pose", "object", "position and orientation of the camera's body frame at that instant"},
                        {"classes", "object", "number of each class, as in semantic pictures, by its name"},
                        {"objects", "array of objects",
                         "id, name, class, class_number, box, box_full, clipped, truncated, pixels, pixels_alone, "
                         "visible_fraction, occluded_by, position, orientation, center, dimensions, velocity; people "
                         "also keypoints and keypoints_world"}},
             .errors = {invalid_argument, not_found, unavailable, unsupported, resource_exhausted},
             .handler = [&context](const nlohmann::json& params,
                                   RpcReply done) { get_truth(context, params, std::move(done)); },
             .example = R"({"camera": "lobby"})",
             .only_looks = true}};
}

}  // namespace camrig
