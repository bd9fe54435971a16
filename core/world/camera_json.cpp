#include "core/world/camera_json.h"

#include <array>
#include <cmath>
#include <span>

#include "core/world/output_check.h"

namespace camrig {
namespace {

using nlohmann::json;

/// Hands a nested result to a reader: the value, or nothing and the error remembered at the key.
template <typename T>
std::optional<T> take(JsonReader& reader, std::string_view key, Result<T> result) {
    if (result) return std::move(*result);
    reader.fail(key, result.error().message, result.error().kind);
    return std::nullopt;
}

/// An optional string that stands for a value.
template <typename T, typename To>
void read_named(JsonReader& reader, std::string_view key, Result<T> (*parse)(std::string_view), To& to) {
    std::optional<std::string> name;
    reader.optional(key, name);
    if (!name) return;
    if (auto value = take(reader, key, parse(*name))) to = *value;
}

void read_size(JsonReader& reader, CameraPatch& patch) {
    const json* value = reader.find("size");
    if (!value) return;
    const bool good =
        value->is_array() && value->size() == 2 && (*value)[0].is_number_integer() && (*value)[1].is_number_integer();
    if (!good) return reader.fail("size", "expected [width, height] in pixels");
    const auto in_range = [](const json& side) {
        // A first fence against numbers that do not fit an int; the exact range is patch_camera_spec's.
        return side.get<double>() >= 0 && side.get<double>() <= 1e6 ? side.get<int>() : 1'000'000;
    };
    patch.size = ImageSize{in_range((*value)[0]), in_range((*value)[1])};
}

void read_rate(JsonReader& reader, CameraPatch& patch) {
    const json* value = reader.find("fps");
    if (!value) return;
    if (value->is_string())
        patch.rate = take(reader, "fps", Rate::parse(value->get_ref<const std::string&>()));
    else if (value->is_number())
        patch.rate = take(reader, "fps", Rate::from_number(value->get<double>()));
    else
        reader.fail("fps", "expected a number or \"num/den\"");
}

void read_mount(JsonReader& reader, CameraPatch& patch) {
    const json* value = reader.find("mount");
    if (!value) return;
    patch.mount.emplace();
    if (value->is_null()) return;
    JsonReader parts(*value, reader.path_of("mount"));
    Mount mount;
    parts.required("actor", mount.actor);
    parts.optional("node", mount.node);
    if (auto done = parts.finish(); !done) return reader.fail(done.error());
    *patch.mount = std::move(mount);
}

/// What camera.get says of a camera's life beside its settings: taken, so that its answer makes a camera, and unused.
constexpr std::array camera_state_keys = {"id", "sequence", "readers", "applied_ns"};

/// Angles given beside others must say the same; this is what rounding to text may cost.
constexpr double agreement_deg = 1e-6;

/// Fields of view beside intrinsics are those camera.get shows; they must belong to the intrinsics, which win.
void check_fields_of_view(JsonReader& reader, const CameraPatch& patch, std::optional<double> vfov_deg,
                          std::optional<double> hfov_deg) {
    if (!vfov_deg && !hfov_deg) return;
    if (!patch.size)
        return reader.fail("intrinsics", "give only one of vfov_deg, hfov_deg and intrinsics, or size too");
    const Intrinsics& k = std::get<Intrinsics>(*patch.optics);
    const auto check = [&](const char* key, std::optional<double> given, double expected_rad) {
        if (given && !(std::abs(*given - glm::degrees(expected_rad)) <= agreement_deg))
            reader.fail(key, "is not that of the intrinsics; give only one of vfov_deg, hfov_deg and intrinsics");
    };
    check("vfov_deg", vfov_deg, vfov_rad(*patch.size, k));
    check("hfov_deg", hfov_deg, hfov_rad(*patch.size, k));
}

void read_optics(JsonReader& reader, CameraPatch& patch) {
    std::optional<double> vfov_deg, hfov_deg;
    reader.optional("vfov_deg", vfov_deg);
    reader.optional("hfov_deg", hfov_deg);
    const json* intrinsics = reader.find("intrinsics");
    if (vfov_deg && hfov_deg && !intrinsics)
        return reader.fail("hfov_deg", "give only one of vfov_deg, hfov_deg and intrinsics");
    if (vfov_deg) patch.optics = VerticalFov{glm::radians(*vfov_deg)};
    if (hfov_deg) patch.optics = HorizontalFov{glm::radians(*hfov_deg)};
    if (!intrinsics) return;
    JsonReader nested(*intrinsics, reader.path_of("intrinsics"));
    Intrinsics k;
    nested.required("fx", k.fx);
    nested.required("fy", k.fy);
    nested.required("cx", k.cx);
    nested.required("cy", k.cy);
    if (auto done = nested.finish(); !done) return reader.fail(done.error());
    patch.optics = k;
    check_fields_of_view(reader, patch, vfov_deg, hfov_deg);
}

/// null is the rig's quality, as camera.get says it.
void read_quality(JsonReader& reader, CameraPatch& patch) {
    const json* value = reader.find("quality");
    if (!value) return;
    std::string name;
    if (value->is_null()) {
        patch.quality.emplace(std::nullopt);
    } else if (reader.required("quality", name); reader.ok()) {
        if (const auto quality = take(reader, "quality", parse_quality(name))) patch.quality.emplace(*quality);
    }
}

void read_lens(JsonReader& reader, CameraPatch& patch) {
    const json* value = reader.find("lens");
    if (!value) return;
    JsonReader nested(*value, reader.path_of("lens"));
    std::string name;
    nested.required("model", name);
    Lens lens;
    if (nested.ok())
        if (const auto model = take(nested, "model", parse_lens_model(name))) lens.model = *model;
    const auto wanted = static_cast<std::size_t>(coefficient_count(lens.model));
    if (nested.ok() && (wanted > 0 || nested.has("coefficients")))
        nested.required("coefficients", std::span<double>(lens.coefficients.data(), wanted));
    LensSampling sampling;
    read_named(nested, "method", parse_lens_method, sampling.method);
    read_named(nested, "filter", parse_lens_filter, sampling.filter);
    nested.optional("oversample", sampling.oversample);
    if (auto done = nested.finish(); !done) return reader.fail(done.error());
    patch.lens = lens;
    patch.lens_sampling = sampling;
}

void read_controls(JsonReader& reader, CameraPatch& patch) {
    const json* value = reader.find("controls");
    if (!value) return;
    JsonReader nested(*value, reader.path_of("controls"));
    ImageControlsPatch& controls = patch.controls;
    nested.optional("auto_exposure", controls.auto_exposure);
    nested.optional("exposure_ev", controls.exposure_ev);
    nested.optional("gain_db", controls.gain_db);
    nested.optional("auto_white_balance", controls.auto_white_balance);
    nested.optional("white_balance_k", controls.white_balance_k);
    nested.optional("brightness", controls.brightness);
    nested.optional("contrast", controls.contrast);
    nested.optional("saturation", controls.saturation);
    // Who gives a value wants to see it.
    if (controls.exposure_ev && !controls.auto_exposure) controls.auto_exposure = false;
    if (controls.white_balance_k && !controls.auto_white_balance) controls.auto_white_balance = false;
    if (auto done = nested.finish(); !done) return reader.fail(done.error());
}

OutputSpec read_output(const json& value, const std::string& path, JsonReader& parent) {
    JsonReader reader(value, path);
    OutputSpec output;
    reader.required("kind", output.kind);
    reader.optional("number", output.number);
    reader.optional("format", output.format);
    reader.optional("subsampling", output.subsampling);
    reader.optional("codec", output.codec);
    reader.optional("quality", output.quality);
    reader.optional("bitrate_kbps", output.bitrate_kbps);
    reader.optional("key_interval_s", output.key_interval_s);
    reader.optional("preset", output.preset);
    reader.optional("profile", output.profile);
    if (auto done = reader.finish(); !done) parent.fail(done.error());
    return output;
}

void read_outputs(JsonReader& reader, CameraPatch& patch) {
    if (!reader.find("outputs")) return;
    std::vector<OutputSpec> outputs;
    const auto items = reader.array("outputs", max_outputs_per_camera);
    for (std::size_t i = 0; i < items.size(); ++i)
        outputs.push_back(read_output(items[i], reader.path_of("outputs") + "[" + std::to_string(i) + "]", reader));
    patch.outputs = std::move(outputs);
}

json controls_to_json(const ImageControls& controls) {
    return {{"auto_exposure", controls.auto_exposure},
            {"exposure_ev", controls.exposure_ev},
            {"gain_db", controls.gain_db},
            {"auto_white_balance", controls.auto_white_balance},
            {"white_balance_k", controls.white_balance_k},
            {"brightness", controls.brightness},
            {"contrast", controls.contrast},
            {"saturation", controls.saturation}};
}

json array_of(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

/// Whether two unit quaternions are one rotation, as far as six digits of an angle in degrees tell.
bool same_turn(const glm::dquat& a, const glm::dquat& b) {
    const glm::dquat between = glm::conjugate(a) * b;
    return glm::length(glm::dvec3(between.x, between.y, between.z)) <= glm::radians(agreement_deg);
}

json output_to_json(const OutputSpec& output) {
    json out = {{"kind", output.kind}};
    if (output.number) out["number"] = *output.number;
    if (!output.format.empty()) out["format"] = output.format;
    if (!output.subsampling.empty()) out["subsampling"] = output.subsampling;
    if (!output.codec.empty()) out["codec"] = output.codec;
    if (output.quality) out["quality"] = *output.quality;
    if (output.bitrate_kbps) out["bitrate_kbps"] = *output.bitrate_kbps;
    if (output.key_interval_s) out["key_interval_s"] = *output.key_interval_s;
    if (!output.preset.empty()) out["preset"] = output.preset;
    if (!output.profile.empty()) out["profile"] = output.profile;
    return out;
}

}  // namespace

CameraPatch read_camera_patch(JsonReader& reader) {
    CameraPatch patch;
    read_size(reader, patch);
    read_rate(reader, patch);
    read_optics(reader, patch);
    reader.optional("zoom", patch.zoom);
    if (const json* pose = reader.find("pose")) {
        if (auto read = read_pose(*pose, reader.path_of("pose")))
            patch.pose = *read;
        else
            reader.fail(read.error());
    }
    read_mount(reader, patch);
    read_lens(reader, patch);
    reader.optional("near", patch.near_m);
    reader.optional("far", patch.far_m);
    read_quality(reader, patch);
    read_named(reader, "antialias", parse_antialias, patch.antialias);
    read_controls(reader, patch);
    reader.optional("code_strip", patch.code_strip);
    read_outputs(reader, patch);
    for (const char* state : camera_state_keys) {
        std::optional<std::int64_t> unused;
        reader.optional(state, unused);
    }
    if (const json* pose = reader.find("world_pose")) {
        if (auto unused = read_pose(*pose, reader.path_of("world_pose")); !unused) reader.fail(unused.error());
    }
    return patch;
}

Result<Pose> read_pose(const json& value, std::string path) {
    JsonReader reader(value, path);
    std::array<double, 3> position{}, target{};
    std::array<double, 4> q{};
    PanTiltRoll angles;
    reader.required("position", std::span<double>(position));
    const bool looks = reader.has("look_at");
    const bool turned = reader.has("orientation");
    const bool angled = reader.has("pan_deg") || reader.has("tilt_deg") || reader.has("roll_deg");
    if (looks && (turned || angled)) reader.fail("look_at", "give only one of look_at, orientation and the angles");
    if (looks) reader.required("look_at", std::span<double>(target));
    if (turned) reader.required("orientation", std::span<double>(q));
    const auto angle = [&](const char* key, double& out) {
        double deg = 0.0;
        reader.optional(key, deg);
        out = glm::radians(deg);
    };
    angle("pan_deg", angles.pan);
    angle("tilt_deg", angles.tilt);
    angle("roll_deg", angles.roll);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());

    const glm::dvec3 eye(position[0], position[1], position[2]);
    auto pose = looks    ? pose_look_at(eye, {target[0], target[1], target[2]})
                : turned ? pose_from_quaternion(eye, glm::dquat(q[3], q[0], q[1], q[2]))
                         : pose_from_angles(eye, angles);
    if (!pose) {
        reader.fail_inside(pose.error());
        return std::unexpected(reader.finish().error());
    }
    if (turned && angled) {
        const auto again = pose_from_angles(eye, angles);
        if (!again || !same_turn(again->orientation, pose->orientation))
            return error(ErrorKind::invalid_argument,
                         path + ": orientation and the angles are not the same direction; give only one of them");
    }
    return pose;
}

json pose_to_json(const Pose& pose) {
    const PanTiltRoll angles = angles_of(pose.orientation);
    const glm::dquat& q = pose.orientation;
    return {{"position", array_of(pose.position)},
            {"orientation", {q.x, q.y, q.z, q.w}},
            {"pan_deg", glm::degrees(angles.pan)},
            {"tilt_deg", glm::degrees(angles.tilt)},
            {"roll_deg", glm::degrees(angles.roll)}};
}

json lens_to_json(const Lens& lens) {
    const auto count = static_cast<std::ptrdiff_t>(coefficient_count(lens.model));
    return {{"model", to_string(lens.model)},
            {"coefficients", std::vector<double>(lens.coefficients.begin(), lens.coefficients.begin() + count)}};
}

json camera_to_json(const CameraSpec& spec) {
    const Intrinsics& k = spec.intrinsics;
    json outputs = json::array();
    for (const OutputSpec& output : spec.outputs) outputs.push_back(output_to_json(output));
    json lens = lens_to_json(spec.lens);
    lens["method"] = to_string(spec.lens_sampling.method);
    lens["filter"] = to_string(spec.lens_sampling.filter);
    lens["oversample"] = spec.lens_sampling.oversample;
    return {
        {"name", spec.name},
        {"size", {spec.size.width, spec.size.height}},
        {"fps", spec.rate.den() == 1 ? json(spec.rate.num()) : json(spec.rate.to_string())},
        {"vfov_deg", glm::degrees(vfov_rad(spec.size, k))},
        {"hfov_deg", glm::degrees(hfov_rad(spec.size, k))},
        {"intrinsics", {{"fx", k.fx}, {"fy", k.fy}, {"cx", k.cx}, {"cy", k.cy}}},
        {"zoom", spec.zoom},
        {"pose", pose_to_json(spec.pose)},
        {"mount", spec.mount ? json{{"actor", spec.mount->actor}, {"node", spec.mount->node}} : json(nullptr)},
        {"lens", std::move(lens)},
        {"antialias", to_string(spec.antialias)},
        {"near", spec.near_m},
        {"far", spec.far_m},
        {"quality", spec.quality ? json(to_string(*spec.quality)) : json(nullptr)},
        {"controls", controls_to_json(spec.controls)},
        {"code_strip", spec.code_strip},
        {"outputs", std::move(outputs)},
    };
}

}  // namespace camrig
