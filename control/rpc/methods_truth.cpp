#include "control/rpc/method_fields.h"
#include "control/rpc/methods.h"
#include "core/truth/truth_json.h"

namespace camrig::control {

std::vector<Method> truth_methods(RpcContext& context) {
    using enum ErrorKind;
    const std::vector<FieldOf<engine::GetTruth>> params{camera_name_at<&engine::GetTruth::camera>("camera"),
                                                        min_ns_at<&engine::GetTruth::min_ns>()};
    return {
        {.name = "truth.get",
         .summary = "The truth of the camera's latest due frame: every object that it sees or would see if nothing "
                    "stood in front, through its lens, at the frame's instant. docs/truth.md explains the members "
                    "of `objects`.",
         .params = descriptions_of(params),
         .result =
             {{"camera", "string", "its name"},
              {"sequence", "integer", "number of the frame, as in frame.get"},
              time_field,
              monotonic_field,
              stamp_field,
              steady_field,
              {"exposure_start_ns", "integer or null",
               "of a camera with a sensor: world time at which the first row begins to count", false, "ns"},
              {"exposure_end_ns", "integer or null", "the same: at which the last row ends, `time_ns`", false, "ns"},
              {"row_ns", "integer or null",
               "the same: from the begin of a row to that of the next; 0: all rows at once", false, "ns"},
              {"sensor", "object or null",
               "of a camera with a sensor: how the frame is taken, as in frame.get; of one whose picture nobody "
               "asked for yet, how it would be"},
              {"size", "[width, height]", "size of the picture", false, "px"},
              {"intrinsics", "object", "see intrinsics"},
              {"lens", "object", "see lens"},
              {"pose", "object", "position and orientation of the camera's body frame at that instant"},
              {"pose_believed", "object",
               "the same as its calibration has it: another one when the camera was knocked"},
              {"faults", "array of objects",
               "what fails at this frame (fault.set): id, kind, layer, severity, since_ns, until_ns"},
              {"delivered", "boolean", "false: a fault keeps the frame back"},
              {"outputs", "object",
               "for each kind of output (mjpeg, rtsp, device, v4l2) what faults make of the frame on the way to its "
               "readers: fate (`sent`, `dropped`, `stalled`, `disconnected`) and late_frames, so many later ones "
               "are due before it comes"},
              {"covered_fraction", "number",
               "share of the picture's pixels of which dirt and covers hide more than half of the light"},
              {"shown_sequence", "integer",
               "the frame whose picture it has, its own but for faults; of one kept back, whose was seen last"},
              {"ptz", "object or null",
               "of a camera on a head: pan_deg, tilt_deg and zoom as it believes, turning, zooming, and under "
               "`true` where it is"},
              {"depth_source", "string",
               "`render`: depth is that of what is drawn; `proxy`: where a backdrop shows, that of its proxies"},
              {"backdrop", "object or null", "of a camera with a backdrop: its kind and file"},
              {"ignore", "array of objects",
               "where the backdrop shows people and vehicles that are not in `objects`: polygon_px in pixels of "
               "this frame, class"},
              {"classes", "object", "number of each class, as in semantic pictures, by its name"},
              {"objects", "array of objects",
               "id, name, class, class_number, box, box_full, clipped, truncated, pixels, pixels_alone, "
               "visible_fraction, occluded_by, position, orientation, center, dimensions, velocity; people "
               "also keypoints and keypoints_world"}},
         .errors = {invalid_argument, not_found, unavailable, unsupported, resource_exhausted},
         .handler = handler_of(context, params, [](const truth::TruthRef& truth) { return truth_to_json(*truth); }),
         .example = R"({"camera": "lobby"})",
         .only_looks = true}};
}

}  // namespace camrig::control
