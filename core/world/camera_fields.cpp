#include "core/world/camera_fields.h"

#include "core/base/output_family.h"
#include "core/base/picture_fields.h"
#include "core/world/camera_json.h"

namespace camrig::world {
namespace {

using nlohmann::json;
using Entry = FieldOf<CameraSpec, CameraPatch>;

/// JSON schema of what does not follow from a type, a range and choices; $defs are those of scenes/schema.json.
constexpr const char* name_schema =
    R"({"type": "string", "minLength": 1, "maxLength": 24, "not": {"pattern": "[^a-z0-9_]"}})";
constexpr const char* size_schema =
    R"({"type": "array", "items": {"type": "integer", "minimum": 16, "maximum": 8192}, "minItems": 2, "maxItems": 2,
        "default": [640, 480]})";
constexpr const char* fps_schema =
    R"({"anyOf": [{"type": "number", "minimum": 0.1, "maximum": 1000},
                  {"type": "string", "pattern": "^[0-9]+(\\.[0-9]+|/[0-9]+)?$"}], "default": 25})";
constexpr const char* outputs_schema =
    R"({"type": "array", "items": {"$ref": "#/$defs/output"}, "maxItems": 16, "uniqueItems": true})";

/// A member of CameraSpec that stands alone.
template <auto member>
Entry camera_at(Field field) {
    return field_at<member, CameraPatch>(std::move(field));
}

/// One that the rig tells: taken, so that the answer of camera.get makes a camera, and unused.
Entry told(Field field) {
    field.by = Field::By::rig;
    Entry entry{.field = field};
    entry.read = [field](JsonReader& reader, CameraPatch&) {
        std::optional<std::int64_t> unused;
        reader.optional(field.name, unused);
    };
    return entry;
}

Entry zoom() {
    Entry entry = camera_at<&CameraSpec::zoom>(
        {.name = "zoom",
         .doc = "scales the focal length; optics are given as they are at the zoom given with them, else at 1",
         .range = {1, 10}});
    entry.read = [field = entry.field](JsonReader& reader, CameraPatch& patch) {
        if (const auto value = read_value<double>(reader, field)) patch.zoom = *value;
    };
    return entry;
}

Entry mount() {
    Entry entry = camera_at<&CameraSpec::mount>({.name = "mount",
                                                 .doc = "see mount",
                                                 .null = "on nothing, where `pose` is in the world",
                                                 .shape = "Mount",
                                                 .is_whole = true});
    entry.read = [field = entry.field](JsonReader& reader, CameraPatch& patch) {
        if (reader.has_null(field.name))
            patch.mount.emplace();
        else if (auto value = read_object<Mount>(reader, field))
            patch.mount.emplace(std::move(*value));
    };
    return entry;
}

Entry backdrop() {
    Entry entry =
        camera_at<&CameraSpec::backdrop>({.name = "backdrop",
                                          .doc = "a picture of a real place that people walk in, see backdrop",
                                          .null = "the scene's own objects are what it sees",
                                          .shape = "Backdrop",
                                          .is_whole = true});
    entry.has_checked_range = false;
    entry.read = [field = entry.field](JsonReader& reader, CameraPatch& patch) {
        if (reader.has_null(field.name))
            patch.backdrop.emplace();
        else if (auto value = read_object<BackdropSpec>(reader, field))
            patch.backdrop.emplace(std::move(*value));
    };
    return entry;
}

void read_pose_of(JsonReader& reader, CameraPatch& patch) {
    const json* value = reader.find("pose");
    if (!value) return;
    if (auto pose = read_pose(*value, reader.path_of("pose")))
        patch.pose = *pose;
    else
        reader.fail(pose.error());
}

void ignore_world_pose(JsonReader& reader, CameraPatch&) {
    const json* value = reader.find("world_pose");
    if (!value) return;
    if (auto unused = read_pose(*value, reader.path_of("world_pose")); !unused) reader.fail(unused.error());
}

void read_outputs(JsonReader& reader, CameraPatch& patch) {
    if (!reader.find("outputs")) return;
    std::vector<OutputSpec> outputs;
    const auto items = reader.array("outputs", max_outputs_per_camera);
    for (std::size_t i = 0; i < items.size(); ++i) {
        JsonReader nested(items[i], reader.path_of("outputs") + "[" + std::to_string(i) + "]");
        OutputSpec output = read_output(nested);
        if (auto done = nested.finish(); !done)
            reader.fail(done.error());
        else
            outputs.push_back(std::move(output));
    }
    patch.outputs = std::move(outputs);
}

json outputs_to_json(const CameraSpec& spec) {
    json outputs = json::array();
    for (const OutputSpec& output : spec.outputs) outputs.push_back(output_to_json(output));
    return outputs;
}

json lens_of(const CameraSpec& spec) {
    json lens = lens_to_json(spec.lens);
    lens.update(write_fields(fields_of(std::type_identity<LensSampling>{}), spec.lens_sampling));
    return lens;
}

std::vector<std::string> model_names() {
    std::vector<std::string> names;
    for (const auto& model : names_of(std::type_identity<camera::LensModel>{})) names.emplace_back(model.name);
    return names;
}

std::vector<Field> lens_parts() {
    std::vector<Field> parts = lens_model_fields();
    for (Field& field : descriptions_of<LensSampling>()) parts.push_back(std::move(field));
    return parts;
}

std::vector<Entry> make_camera_fields() {
    return {
        {.field =
             {.name = "name", .type = "string", .doc = "`[a-z0-9_]{1,24}`", .required = true, .schema = name_schema},
         .write = [](const CameraSpec& spec) { return json(spec.name); }},
        {.field = {.name = "place",
                   .type = "string",
                   .doc = "a place of the scene: its pose and field of view, unless given",
                   .by = Field::By::client}},
        {.field = {.name = "size",
                   .type = "[width, height]",
                   .doc = "16x16 to 8192x8192",
                   .unit = "px",
                   .fallback = "[640, 480]",
                   .schema = size_schema},
         .read = read_size,
         .write = [](const CameraSpec& spec) { return size_to_json(spec.size); }},
        {.field = {.name = "fps",
                   .type = "number or \"num/den\"",
                   .doc = "1/10 to 1000",
                   .unit = "1/s",
                   .fallback = "25",
                   .label = "frame rate",
                   .schema = fps_schema},
         .read = read_rate,
         .write = [](const CameraSpec& spec) { return rate_to_json(spec.rate); }},
        {.field = {.name = "vfov_deg",
                   .type = "number",
                   .doc = "vertical field of view, edge to edge; give hfov_deg or intrinsics instead",
                   .unit = "deg",
                   .fallback = "60",
                   .range = {0.01, 179.9, true, true},
                   .label = "vertical field of view",
                   .schema = R"({"$ref": "#/$defs/field_of_view", "default": 60})"},
         .read = read_optics,
         .write = [](const CameraSpec& spec) { return json(glm::degrees(vfov_rad(spec.size, spec.intrinsics))); }},
        {.field = {.name = "hfov_deg",
                   .type = "number",
                   .doc = "horizontal field of view, edge to edge",
                   .unit = "deg",
                   .range = {0.01, 179.9, true, true},
                   .label = "horizontal field of view",
                   .schema = R"({"$ref": "#/$defs/field_of_view"})"},
         .write = [](const CameraSpec& spec) { return json(glm::degrees(hfov_rad(spec.size, spec.intrinsics))); }},
        {.field = {.name = "intrinsics",
                   .type = "object",
                   .doc = "see intrinsics; in an answer, as they follow from the above and zoom",
                   .unit = "px",
                   .parts = descriptions_of<camera::Intrinsics>(),
                   .shape = "Intrinsics",
                   .is_whole = true},
         .write =
             [](const CameraSpec& spec) {
                 return write_fields(fields_of(std::type_identity<camera::Intrinsics>{}), spec.intrinsics);
             }},
        zoom(),
        {.field = {.name = "pose",
                   .type = "object",
                   .doc =
                       "see pose; in the frame of its mount, if it has one. A camera without it and without a `place` "
                       "is at the origin and looks along +x",
                   .parts = pose_fields(),
                   .shape = "Pose",
                   .is_whole = true,
                   .schema = R"({"$ref": "#/$defs/pose"})"},
         .read = read_pose_of,
         .write = [](const CameraSpec& spec) { return pose_to_json(spec.pose); }},
        mount(),
        camera_at<&CameraSpec::ptz>({
            .name = "ptz",
            .doc = "the head that turns and zooms it, see ptz; `pose` is where it looks at pan and tilt 0",
            .null = "no head",
            .shape = "Ptz",
        }),
        camera_at<&CameraSpec::clock>(
            {.name = "clock",
             .doc = "its own clock, see clock: what its stamps say and when it exposes, each wrong on its own",
             .null = "none, it is right",
             .shape = "Clock"}),
        camera_at<&CameraSpec::sensor>(
            {.name = "sensor",
             .doc = "counts electrons as a real camera does, see sensor: exposure, noise, saturation, raw numbers",
             .null = "none: light of 1 is white",
             .shape = "Sensor"}),
        backdrop(),
        {.field = {.name = "lens",
                   .type = "object",
                   .doc = "see lens",
                   .fallback = "pinhole",
                   .parts = lens_parts(),
                   .shape = "Lens",
                   .is_whole = true,
                   .schema = R"({"$ref": "#/$defs/lens"})"},
         .read = read_lens,
         .write = lens_of},
        camera_at<&CameraSpec::antialias>(
            {.name = "antialias",
             .doc = "samples of a pixel of the colour picture; coverage: each surface by how much of the pixel it "
                    "covers, of 64 places, shaded once (as msaa4 on a GPU), msaa4: four coverage samples, "
                    "ssaa2 to ssaa4: 2x2 to 4x4 full samples, auto: coverage at quality beautiful up to 4 "
                    "megapixels, else none"}),
        camera_at<&CameraSpec::near_m>(
            {.name = "near", .doc = "nearest distance drawn", .unit = "m", .range = {0, 1e6, true}}),
        camera_at<&CameraSpec::far_m>({.name = "far",
                                       .doc = "farthest distance drawn, over near; 0: no limit",
                                       .unit = "m",
                                       .range = {.low = 0}}),
        camera_at<&CameraSpec::quality>({.name = "quality", .null = "the rig's"}),
        camera_at<&CameraSpec::exposure_ev>(
            {.name = "exposure_ev",
             .doc = "stops by which it is exposed more than the scene's `exposure` has it, before anything is cut at "
                    "white; of cameras without sensor and backdrop",
             .unit = "EV",
             .range = {-20, 20}}),
        camera_at<&CameraSpec::controls>({.name = "controls",
                                          .doc = "see controls; what is not given in it stays",
                                          .shape = "Controls",
                                          .option = "set-ctrl"}),
        camera_at<&CameraSpec::code_strip>(
            {.name = "code_strip",
             .doc = "draws camera number, sequence and world time into the picture; needs 128x32 pixels"}),
        camera_at<&CameraSpec::clock_text>(
            {.name = "clock_text",
             .doc = "burns days, hours, minutes and seconds of world time as its clock has it into the lower left "
                    "corner of the picture; needs 128x32 pixels"}),
        camera_at<&CameraSpec::description>({.name = "description",
                                             .doc = "free text of yours: where it hangs, what it is for",
                                             .range = {.high = 200}}),
        camera_at<&CameraSpec::group>({.name = "group",
                                       .doc =
                                           "a name of yours: of cameras with the same (a stereo pair) the pictures of "
                                           "an instant are all drawn or all dropped",
                                       .range = {.high = 24}}),
        {.field = {.name = "outputs",
                   .type = "array of objects",
                   .doc = "at most 16, no two the same, all of them given; see outputs",
                   .fallback = "[]",
                   .parts = output_fields(),
                   .shape = "Output",
                   .schema = outputs_schema},
         .read = read_outputs,
         .write = outputs_to_json},
        {.field = {.name = "world_pose",
                   .type = "object",
                   .doc = "where it is in the world, as pose; of a mounted camera, at its latest due frame",
                   .parts = pose_fields(),
                   .shape = "Pose",
                   .is_whole = true,
                   .by = Field::By::rig},
         .read = ignore_world_pose},
        {.field = {.name = "shown_intrinsics",
                   .type = "object",
                   .doc = "intrinsics of its picture now, with what its head zooms",
                   .unit = "px",
                   .parts = descriptions_of<camera::Intrinsics>(),
                   .shape = "Intrinsics",
                   .is_whole = true,
                   .by = Field::By::rig},
         .read =
             [](JsonReader& reader, CameraPatch&) {
                 static_cast<void>(read_object<camera::Intrinsics>(reader, {.name = "shown_intrinsics"}));
             }},
        told({.name = "id", .type = "integer", .doc = "one life of a camera; never used again"}),
        told({.name = "sequence", .type = "integer", .doc = "number of its latest due frame"}),
        told({.name = "readers", .type = "integer", .doc = "how many watch it now"}),
        told({.name = "applied_ns", .type = "integer", .doc = "world time from which this state shows", .unit = "ns"}),
        told({.name = "arrives_ns",
              .type = "integer",
              .doc = "world time from which it is where its last command sent it",
              .unit = "ns"}),
    };
}

}  // namespace

const std::vector<Entry>& camera_fields() {
    static const std::vector<Entry> table = make_camera_fields();
    return table;
}

const std::vector<Field>& lens_model_fields() {
    static const std::vector<Field> fields{
        {.name = "model",
         .type = "string",
         .doc = "with k1 k2 p1 p2 k3 of plumb_bob, k1 k2 p1 p2 k3 k4 k5 k6 of rational_polynomial, k1 k2 k3 k4 of "
                "equidistant",
         .required = true,
         .choices = model_names()},
        {.name = "coefficients", .type = "array of numbers", .doc = "as many as the model has; pinhole has none"}};
    return fields;
}

const std::vector<Field>& pose_fields() {
    static const std::vector<Field> fields{
        {.name = "position", .type = "[x, y, z]", .doc = "where it is", .required = true, .unit = "m"},
        {.name = "look_at",
         .type = "[x, y, z]",
         .doc = "the point in the middle of the picture; the horizon stays level",
         .unit = "m",
         .by = Field::By::client},
        {.name = "pan_deg",
         .type = "number",
         .doc = "about world z, counter-clockwise from above; 0 looks along +x",
         .unit = "deg",
         .fallback = "0",
         .label = "pan"},
        {.name = "tilt_deg",
         .type = "number",
         .doc = "positive looks up",
         .unit = "deg",
         .fallback = "0",
         .label = "tilt"},
        {.name = "roll_deg",
         .type = "number",
         .doc = "about the viewing direction, clockwise seen from behind the camera",
         .unit = "deg",
         .fallback = "0",
         .label = "roll"},
        {.name = "orientation",
         .type = "[x, y, z, w]",
         .doc = "quaternion of the body frame: x forward, y left, z up"}};
    return fields;
}

FieldTable<Mount> fields_of(std::type_identity<Mount>) {
    static const std::vector<FieldOf<Mount>> table{
        field_at<&Mount::actor>({.name = "actor", .doc = "its name", .required = true}),
        field_at<&Mount::node>(
            {.name = "node",
             .doc =
                 "a node of its model: the frame is at the node and turns as the node does in its clips; at rest, one "
                 "without a turn of its own has the axes of the actor. Empty: the actor's own frame, at its origin"}),
    };
    return table;
}

}  // namespace camrig::world
