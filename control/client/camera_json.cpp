#include "control/client/camera_json.h"

#include <camrig/error.h>

#include "core/base/rate.h"

namespace camrig::client {
namespace {

using nlohmann::json;

Rate rate_of(const Result<camrig::Rate>& exact) {
    if (!exact) throw Error("invalid_argument", "fps: " + exact.error().message);
    return {exact->num(), exact->den()};
}

Rate rate_of(const json& value) {
    return rate_of(value.is_string() ? camrig::Rate::parse(value.get<std::string>())
                                     : camrig::Rate::from_number(value.get<double>()));
}

template <typename T>
void put(json& object, const char* key, const std::optional<T>& value) {
    if (value) object[key] = *value;
}

template <typename T>
void take(const json& object, const char* key, std::optional<T>& value) {
    if (const auto found = object.find(key); found != object.end() && !found->is_null()) value = found->get<T>();
}

/// A string of which "none" is null in the protocol and empty here.
json or_null(const std::string& text) {
    return text.empty() ? json(nullptr) : json(text);
}

json json_of(const Mount& mount) {
    return mount.actor.empty() ? json(nullptr) : json{{"actor", mount.actor}, {"node", mount.node}};
}

json json_of(const Lens& lens) {
    return {{"model", lens.model},
            {"coefficients", lens.coefficients},
            {"method", lens.method},
            {"filter", lens.filter},
            {"oversample", lens.oversample}};
}

json json_of(const Controls& controls) {
    json value = json::object();
    put(value, "auto_exposure", controls.auto_exposure);
    put(value, "exposure_ev", controls.exposure_ev);
    put(value, "gain_db", controls.gain_db);
    put(value, "auto_white_balance", controls.auto_white_balance);
    put(value, "white_balance_k", controls.white_balance_k);
    put(value, "brightness", controls.brightness);
    put(value, "contrast", controls.contrast);
    put(value, "saturation", controls.saturation);
    return value;
}

json json_of(const Output& output) {
    json value{{"kind", output.kind}};
    put(value, "number", output.number);
    put(value, "format", output.format);
    put(value, "subsampling", output.subsampling);
    put(value, "codec", output.codec);
    put(value, "quality", output.quality);
    put(value, "bitrate_kbps", output.bitrate_kbps);
    put(value, "key_interval_s", output.key_interval_s);
    put(value, "preset", output.preset);
    put(value, "profile", output.profile);
    return value;
}

Pose pose_of(const json& value) {
    return {value.at("position").get<Vector3>(), value.at("orientation").get<std::array<double, 4>>(),
            value.at("pan_deg").get<double>(), value.at("tilt_deg").get<double>(), value.at("roll_deg").get<double>()};
}

Lens lens_of(const json& value) {
    Lens lens;
    lens.model = value.at("model").get<std::string>();
    lens.coefficients = value.at("coefficients").get<std::vector<double>>();
    lens.method = value.value("method", lens.method);
    lens.filter = value.value("filter", lens.filter);
    lens.oversample = value.value("oversample", lens.oversample);
    return lens;
}

Controls controls_of(const json& value) {
    Controls controls;
    take(value, "auto_exposure", controls.auto_exposure);
    take(value, "exposure_ev", controls.exposure_ev);
    take(value, "gain_db", controls.gain_db);
    take(value, "auto_white_balance", controls.auto_white_balance);
    take(value, "white_balance_k", controls.white_balance_k);
    take(value, "brightness", controls.brightness);
    take(value, "contrast", controls.contrast);
    take(value, "saturation", controls.saturation);
    return controls;
}

Output output_of(const json& value) {
    Output output;
    output.kind = value.at("kind").get<std::string>();
    take(value, "number", output.number);
    take(value, "format", output.format);
    take(value, "subsampling", output.subsampling);
    take(value, "codec", output.codec);
    take(value, "quality", output.quality);
    take(value, "bitrate_kbps", output.bitrate_kbps);
    take(value, "key_interval_s", output.key_interval_s);
    take(value, "preset", output.preset);
    take(value, "profile", output.profile);
    return output;
}

std::string text_or_empty(const json& value) {
    return value.is_null() ? std::string() : value.get<std::string>();
}

CameraState read_camera(const json& value) {
    CameraState state;
    state.name = value.at("name").get<std::string>();
    state.size = {value.at("size").at(0).get<int>(), value.at("size").at(1).get<int>()};
    state.fps = rate_of(value.at("fps"));
    state.vfov_deg = value.at("vfov_deg").get<double>();
    state.hfov_deg = value.at("hfov_deg").get<double>();
    const json& k = value.at("intrinsics");
    state.intrinsics = {k.at("fx").get<double>(), k.at("fy").get<double>(), k.at("cx").get<double>(),
                        k.at("cy").get<double>()};
    state.zoom = value.at("zoom").get<double>();
    state.pose = pose_of(value.at("pose"));
    if (const json& mount = value.at("mount"); !mount.is_null())
        state.mount = Mount{mount.at("actor").get<std::string>(), mount.value("node", "")};
    state.world_pose = pose_of(value.at("world_pose"));
    state.lens = lens_of(value.at("lens"));
    state.antialias = value.at("antialias").get<std::string>();
    state.near = value.at("near").get<double>();
    state.far = value.at("far").get<double>();
    state.quality = text_or_empty(value.at("quality"));
    state.controls = controls_of(value.at("controls"));
    state.code_strip = value.at("code_strip").get<bool>();
    for (const json& output : value.at("outputs")) state.outputs.push_back(output_of(output));
    state.id = value.at("id").get<std::int64_t>();
    state.sequence = value.at("sequence").get<std::int64_t>();
    state.readers = value.at("readers").get<int>();
    state.applied_ns = value.at("applied_ns").get<std::int64_t>();
    return state;
}

WorldStatus read_world(const json& value) {
    WorldStatus world;
    world.scene = value.at("scene").get<std::string>();
    world.scene_file = value.at("scene_file").get<std::string>();
    world.mode = value.at("mode").get<std::string>();
    world.overload = value.at("overload").get<std::string>();
    world.quality = value.at("quality").get<std::string>();
    world.paused = value.at("paused").get<bool>();
    world.world_ns = value.at("world_ns").get<std::int64_t>();
    world.step_ns = value.at("step_ns").get<std::int64_t>();
    world.seed = value.at("seed").get<std::uint64_t>();
    world.state_ns = value.at("state_ns").get<std::int64_t>();
    world.state_hash = value.at("state_hash").get<std::string>();
    world.objects = value.at("objects").get<int>();
    world.actors = value.at("actors").get<int>();
    world.cameras = value.at("cameras").get<int>();
    world.places = value.at("places").get<std::vector<std::string>>();
    world.applied_ns = value.at("applied_ns").get<std::int64_t>();
    return world;
}

template <typename Read>
auto read(const char* what, const json& answer, Read function) {
    try {
        return function(answer);
    } catch (const json::exception& problem) {
        throw Error("internal", std::string(what) + ": the rig's answer is not as expected: " + problem.what());
    }
}

}  // namespace

Rate::Rate(double hertz) : Rate(rate_of(camrig::Rate::from_number(hertz))) {}

CameraOptions CameraState::options() const {
    CameraOptions options;
    options.size = size;
    options.fps = fps;
    options.intrinsics = intrinsics;
    options.zoom = zoom;
    options.position = pose.position;
    options.orientation = pose.orientation;
    options.mount = mount;
    options.lens = lens;
    options.antialias = antialias;
    options.near = near;
    options.far = far;
    options.quality = quality;
    options.controls = controls;
    options.code_strip = code_strip;
    return options;
}

json params_of(const CameraOptions& options) {
    json params = json::object();
    put(params, "place", options.place);
    if (options.size) params["size"] = {options.size->width, options.size->height};
    if (options.fps) params["fps"] = std::to_string(options.fps->num) + "/" + std::to_string(options.fps->den);
    put(params, "vfov_deg", options.vfov_deg);
    put(params, "hfov_deg", options.hfov_deg);
    if (const auto& k = options.intrinsics)
        params["intrinsics"] = {{"fx", k->fx}, {"fy", k->fy}, {"cx", k->cx}, {"cy", k->cy}};
    put(params, "zoom", options.zoom);
    json pose = json::object();
    put(pose, "position", options.position);
    put(pose, "look_at", options.look_at);
    put(pose, "pan_deg", options.pan_deg);
    put(pose, "tilt_deg", options.tilt_deg);
    put(pose, "roll_deg", options.roll_deg);
    put(pose, "orientation", options.orientation);
    if (!pose.empty()) params["pose"] = std::move(pose);
    if (options.mount) params["mount"] = json_of(*options.mount);
    if (options.lens) params["lens"] = json_of(*options.lens);
    put(params, "antialias", options.antialias);
    put(params, "near", options.near);
    put(params, "far", options.far);
    if (options.quality) params["quality"] = or_null(*options.quality);
    if (options.controls) params["controls"] = json_of(*options.controls);
    put(params, "code_strip", options.code_strip);
    if (options.outputs) {
        params["outputs"] = json::array();
        for (const Output& output : *options.outputs) params["outputs"].push_back(json_of(output));
    }
    return params;
}

CameraState camera_state_of(const json& answer) {
    return read("camera", answer, read_camera);
}

WorldStatus world_status_of(const json& answer) {
    return read("world", answer, read_world);
}

}  // namespace camrig::client
