#include "core/world/camera_json.h"

#include <array>
#include <cmath>
#include <span>

#include "core/base/picture_fields.h"
#include "core/world/camera_fields.h"

namespace camrig::world {
namespace {

using nlohmann::json;

/// Angles given beside others must say the same; this is what rounding to text may cost.
constexpr double agreement_deg = 1e-6;

/// Hands a nested result to a reader: the value, or nothing and the error remembered at the key.
template <typename T>
std::optional<T> take(JsonReader& reader, std::string_view key, Result<T> result) {
    if (result) return std::move(*result);
    reader.fail(key, result.error().message, result.error().kind);
    return std::nullopt;
}

/// Fields of view beside intrinsics are those camera.get shows; they must belong to the intrinsics, which win.
void check_fields_of_view(JsonReader& reader, const CameraPatch& patch, std::optional<double> vfov_deg,
                          std::optional<double> hfov_deg) {
    if (!vfov_deg && !hfov_deg) return;
    if (!patch.size)
        return reader.fail("intrinsics", "give only one of vfov_deg, hfov_deg and intrinsics, or size too");
    const camera::Intrinsics& k = std::get<camera::Intrinsics>(*patch.optics);
    const auto check = [&](const char* key, std::optional<double> given, double expected_rad) {
        if (given && !(std::abs(*given - glm::degrees(expected_rad)) <= agreement_deg))
            reader.fail(key, "is not that of the intrinsics; give only one of vfov_deg, hfov_deg and intrinsics");
    };
    check("vfov_deg", vfov_deg, vfov_rad(*patch.size, k));
    check("hfov_deg", hfov_deg, hfov_rad(*patch.size, k));
}

json array_of(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

/// Whether two unit quaternions are one rotation, as far as six digits of an angle in degrees tell.
bool same_turn(const glm::dquat& a, const glm::dquat& b) {
    const glm::dquat between = glm::conjugate(a) * b;
    return glm::length(glm::dvec3(between.x, between.y, between.z)) <= glm::radians(agreement_deg);
}

}  // namespace

void read_size(JsonReader& reader, CameraPatch& patch) {
    patch.size = camrig::read_size(reader, "size");
}

void read_rate(JsonReader& reader, CameraPatch& patch) {
    patch.rate = camrig::read_rate(reader, "fps");
}

void read_optics(JsonReader& reader, CameraPatch& patch) {
    std::optional<double> vfov_deg, hfov_deg;
    reader.optional("vfov_deg", vfov_deg);
    reader.optional("hfov_deg", hfov_deg);
    const bool has_intrinsics = reader.find("intrinsics") != nullptr;
    if (vfov_deg && hfov_deg && !has_intrinsics)
        return reader.fail("hfov_deg", "give only one of vfov_deg, hfov_deg and intrinsics");
    if (vfov_deg) patch.optics = VerticalFov{glm::radians(*vfov_deg)};
    if (hfov_deg) patch.optics = HorizontalFov{glm::radians(*hfov_deg)};
    static const Field field{.name = "intrinsics"};
    const auto k = read_object<camera::Intrinsics>(reader, field);
    if (!k) return;
    patch.optics = *k;
    check_fields_of_view(reader, patch, vfov_deg, hfov_deg);
}

namespace {

/// Model and coefficients.
camera::Lens read_model(JsonReader& nested) {
    std::string name;
    nested.required("model", name);
    camera::Lens lens;
    if (nested.ok())
        if (const auto model = take(nested, "model", parse_name<camera::LensModel>(name))) lens.model = *model;
    const auto wanted = static_cast<std::size_t>(coefficient_count(lens.model));
    if (nested.ok() && (wanted > 0 || nested.has("coefficients")))
        nested.required("coefficients", std::span<double>(lens.coefficients.data(), wanted));
    return lens;
}

}  // namespace

Result<camera::Lens> read_lens_model(const json& value, std::string path) {
    JsonReader reader(value, std::move(path));
    const camera::Lens lens = read_model(reader);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return lens;
}

void read_lens(JsonReader& reader, CameraPatch& patch) {
    const json* value = reader.find("lens");
    if (!value) return;
    JsonReader nested(*value, reader.path_of("lens"));
    const camera::Lens lens = read_model(nested);
    Changes<LensSampling> sampling;
    read_fields(fields_of(std::type_identity<LensSampling>{}), nested, sampling);
    if (auto done = nested.finish(); !done) return reader.fail(done.error());
    patch.lens = lens;
    sampling.apply_to(patch.lens_sampling.emplace());
}

CameraPatch read_camera_patch(JsonReader& reader) {
    CameraPatch patch;
    read_fields(camera_fields(), reader, patch);
    return patch;
}

json camera_to_json(const CameraSpec& spec) {
    return write_fields(camera_fields(), spec);
}

Result<camera::Pose> read_pose(const json& value, std::string path) {
    JsonReader reader(value, path);
    std::array<double, 3> position{}, target{};
    std::array<double, 4> q{};
    camera::PanTiltRoll angles;
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
    auto pose = looks    ? camera::pose_look_at(eye, {target[0], target[1], target[2]})
                : turned ? camera::pose_from_quaternion(eye, glm::dquat(q[3], q[0], q[1], q[2]))
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

json pose_to_json(const camera::Pose& pose) {
    const camera::PanTiltRoll angles = camera::angles_of(pose.orientation);
    const glm::dquat& q = pose.orientation;
    return {{"position", array_of(pose.position)},
            {"orientation", {q.x, q.y, q.z, q.w}},
            {"pan_deg", glm::degrees(angles.pan)},
            {"tilt_deg", glm::degrees(angles.tilt)},
            {"roll_deg", glm::degrees(angles.roll)}};
}

json ptz_to_json(const camera::PtzPosition& position) {
    return {{"pan_deg", position.pan_deg}, {"tilt_deg", position.tilt_deg}, {"zoom", position.zoom}};
}

json ptz_to_json(const camera::PtzStatus& status) {
    json value = ptz_to_json(status.position);
    value["turning"] = status.is_turning;
    value["zooming"] = status.is_zooming;
    value["true"] = ptz_to_json(status.true_position);
    return value;
}

json lens_to_json(const camera::Lens& lens) {
    const auto count = static_cast<std::ptrdiff_t>(coefficient_count(lens.model));
    return {{"model", to_string(lens.model)},
            {"coefficients", std::vector<double>(lens.coefficients.begin(), lens.coefficients.begin() + count)}};
}

}  // namespace camrig::world
