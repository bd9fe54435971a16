#include "core/photo/plate_json.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/camera/camera_model.h"
#include "core/daylight/sun.h"

namespace camrig::photo {
namespace {

using nlohmann::json;

/// The ground of a new camera reaches this far.
constexpr double ground_reach_m = 80.0;

glm::dvec2 read_pixel(JsonReader& reader, std::string_view key) {
    std::array<double, 2> px{};
    reader.required(key, std::span<double>(px));
    return {px[0], px[1]};
}

/// [x, y] is on the ground.
glm::dvec3 read_metres(JsonReader& reader, std::string_view key) {
    const json* const value = reader.find(key);
    std::array<double, 3> m{};
    reader.required(key, std::span<double>(m).first(value && value->is_array() && value->size() == 2 ? 2 : 3));
    return {m[0], m[1], m[2]};
}

template <typename T, typename Read>
std::vector<T> read_list(JsonReader& reader, const char* key, std::size_t most, Read read) {
    std::vector<T> list;
    for (const json& each : reader.array(key, most)) {
        JsonReader item(each, reader.path_of(key) + "[" + std::to_string(list.size()) + "]");
        list.push_back(read(item));
        if (auto done = item.finish(); !done) {
            reader.fail(done.error());
            break;
        }
    }
    return list;
}

AxisLine read_line(JsonReader& reader) {
    AxisLine line;
    std::string axis;
    reader.required("axis", axis);
    if (axis == "x" || axis == "y" || axis == "z")
        line.axis = Axis(axis[0] - 'x');
    else
        reader.fail("axis", "must be x, y or z");
    line.from_px = read_pixel(reader, "from_px");
    line.to_px = read_pixel(reader, "to_px");
    return line;
}

KnownHeight read_height(JsonReader& reader) {
    KnownHeight height;
    height.foot_px = read_pixel(reader, "foot_px");
    height.head_px = read_pixel(reader, "head_px");
    reader.required("height_m", height.height_m);
    reader.optional("z", height.z);
    return height;
}

std::optional<camera::Intrinsics> read_intrinsics(JsonReader& reader, ImageSize size) {
    const bool has_vfov = reader.has("vfov_deg"), has_numbers = reader.has("intrinsics");
    if (has_vfov && has_numbers) reader.fail("vfov_deg", "intrinsics are given too; leave one out");
    Result<camera::Intrinsics> k = camera::Intrinsics{};
    if (has_vfov) {
        double vfov = 0.0;
        reader.required("vfov_deg", vfov);
        if (!reader.ok()) return {};
        k = camera::intrinsics_from_vfov(size, glm::radians(vfov));
        if (!k) reader.fail("vfov_deg", k.error().message);
        return k ? std::optional(*k) : std::nullopt;
    }
    const json* const value = reader.find("intrinsics");
    if (!value) return {};
    JsonReader numbers(*value, reader.path_of("intrinsics"));
    numbers.required("fx", k->fx);
    numbers.required("fy", k->fy);
    numbers.required("cx", k->cx);
    numbers.required("cy", k->cy);
    if (auto done = numbers.finish(); !done)
        reader.fail(done.error());
    else if (auto good = camera::check_intrinsics(size, *k); !good)
        reader.fail("intrinsics", good.error().message);
    return *k;
}

camera::Lens read_lens(JsonReader& reader) {
    const json* const value = reader.find("lens");
    if (!value) return {};
    JsonReader keys(*value, reader.path_of("lens"));
    std::string name;
    keys.required("model", name);
    std::vector<double> numbers;
    for (const json& each : keys.array("coefficients", 8)) {
        if (each.is_number())
            numbers.push_back(each.get<double>());
        else
            keys.fail("coefficients", "must be numbers");
    }
    camera::Lens lens;
    if (auto done = keys.finish(); !done) {
        reader.fail(done.error());
        return lens;
    }
    for (const auto& each : names_of(std::type_identity<camera::LensModel>{}))
        if (each.name == name) {
            auto made = camera::make_lens(each.value, numbers);
            if (!made) reader.fail("lens", made.error().message);
            return made.value_or(lens);
        }
    reader.fail("lens", "model: no such lens: " + name);
    return lens;
}

ImageSize read_size(JsonReader& reader, std::optional<ImageSize> known) {
    if (known && !reader.has("size")) return *known;
    std::array<double, 2> sides{};
    reader.required("size", std::span<double>(sides));
    const ImageSize size{int(sides[0]), int(sides[1])};
    if (reader.ok() &&
        std::ranges::any_of(sides, [](double side) { return side < min_photo_side || side > max_photo_side; }))
        reader.fail("size", "must be from 16x16 to 16384x16384");
    else if (known && reader.ok() && (size.width != known->width || size.height != known->height))
        reader.fail("size", "is " + size.to_string() + ", and the photo is " + known->to_string());
    return size;
}

json vector_json(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

json or_null(const std::optional<double>& value) {
    return value ? json(*value) : json();
}

}  // namespace

PlateTask read_plate_task(JsonReader& reader, std::optional<ImageSize> size, const std::optional<KnownCamera>& known) {
    PlateTask task;
    task.size = read_size(reader, size);
    if (!reader.ok()) return task;
    task.intrinsics = read_intrinsics(reader, task.size);
    task.lens = read_lens(reader);
    if (known && (task.intrinsics || reader.has("lens")))
        reader.fail("intrinsics", "a file of the camera is given too");
    if (known) {
        task.intrinsics = known->intrinsics;
        task.lens = known->lens;
    }
    if (reader.has("principal_px")) {
        task.principal_px = read_pixel(reader, "principal_px");
        if (task.intrinsics) reader.fail("principal_px", "intrinsics are given, which have it");
    }
    reader.optional("fit_k1", task.fit_k1);
    reader.optional("click_px", task.click_px);
    reader.optional("camera_height_m", task.camera_height_m);
    task.points = read_list<KnownPoint>(reader, "points", max_plate_points, [](JsonReader& item) {
        return KnownPoint{read_pixel(item, "px"), read_metres(item, "m")};
    });
    task.heights = read_list<KnownHeight>(reader, "heights", max_plate_heights, read_height);
    task.lines = read_list<AxisLine>(reader, "lines", max_plate_lines, read_line);
    return task;
}

std::optional<KnownCamera> read_known_camera(JsonReader& reader) {
    constexpr std::size_t most_files = 2;
    std::string image;
    reader.optional("camera_image", image);
    const json* const files = reader.find("camera_files");
    if (!files) {
        if (!image.empty()) reader.fail("camera_image", "is that of camera_files, and none are given");
        return std::nullopt;
    }
    std::map<std::string, std::string> texts;
    bool is_good = files->is_object() && files->size() <= most_files;
    if (is_good)
        for (const auto& [name, text] : files->items()) {
            is_good &= text.is_string();
            if (text.is_string()) texts.emplace(name, text.get<std::string>());
        }
    if (!is_good) {
        reader.fail("camera_files", "expected an object from one or two file names to what the files hold");
        return std::nullopt;
    }
    std::optional<ImageSize> size;
    if (reader.has("size")) size = read_size(reader, std::nullopt);
    if (!reader.ok()) return std::nullopt;
    auto known = parse_camera_files(texts, image, size);
    if (known) return *known;
    reader.fail("camera_files", known.error().message, known.error().kind);
    return std::nullopt;
}

json camera_json(ImageSize size, const camera::Intrinsics& k, const camera::Lens& lens, const camera::Pose& pose) {
    const camera::PanTiltRoll angles = camera::angles_of(pose.orientation);
    json entry{{"size", {size.width, size.height}},
               {"intrinsics", {{"fx", k.fx}, {"fy", k.fy}, {"cx", k.cx}, {"cy", k.cy}}},
               {"pose",
                {{"position", vector_json(pose.position)},
                 {"pan_deg", glm::degrees(angles.pan)},
                 {"tilt_deg", glm::degrees(angles.tilt)},
                 {"roll_deg", glm::degrees(angles.roll)}}}};
    const auto coefficients = std::span(lens.coefficients).first(std::size_t(coefficient_count(lens.model)));
    if (std::ranges::any_of(coefficients, [](double c) { return c != 0.0; }))
        entry["lens"] = {{"model", to_string(lens.model)},
                         {"coefficients", std::vector<double>(coefficients.begin(), coefficients.end())}};
    return entry;
}

json ground_json(const PlateView& view, ImageSize size) {
    const auto upper = [&](double x) -> std::optional<double> {
        std::optional<double> found;
        for (double y = size.height - 1; y >= 0; y -= 1.0) {
            const auto at = view.on_ground({x, y}, 0.0);
            if (!at || glm::distance(*at, view.position) > ground_reach_m) break;
            found = y;
        }
        return found;
    };
    const double right = size.width - 1, bottom = size.height - 1;
    const auto one = upper(0.0), other = upper(right);
    if (!one || !other) return nullptr;
    return {{"polygon_px", {{0.0, bottom}, {right, bottom}, {right, *other}, {0.0, *one}}}};
}

json to_json(const PlateCalibration& found) {
    const auto lens = camera::LensMap::create(found.lens);
    const json ground = lens ? ground_json({.k = found.intrinsics,
                                            .lens = *lens,
                                            .world_from_optical = camera::world_from_optical_rotation(found.pose),
                                            .position = found.pose.position},
                                           found.size)
                             : json();
    json residuals = json::array();
    for (const PlateResidual& each : found.residuals)
        residuals.push_back({{"of", each.of}, {"px", each.px}, {"off_px", {each.off_px.x, each.off_px.y}}});
    json names = json::array(), rows = json::array();
    const std::size_t count = found.unknowns.size();
    for (std::size_t n = 0; n < count; ++n) {
        names.push_back(name_of(found.unknowns[n]));
        const auto row = found.covariance.begin() + std::ptrdiff_t(n * count);
        rows.push_back(std::vector<double>(row, row + std::ptrdiff_t(count)));
    }
    const auto& half = found.half_95;
    return {{"camera", camera_json(found.size, found.intrinsics, found.lens, found.pose)},
            {"verdict", name_of(found.grade)},
            {"reason", found.verdict},
            {"half_95",
             {{"position", vector_json(half.position_m)},
              {"pan_deg", glm::degrees(half.angles.pan)},
              {"tilt_deg", glm::degrees(half.angles.tilt)},
              {"roll_deg", glm::degrees(half.angles.roll)},
              {"focal_px", half.focal_px},
              {"k1", half.k1}}},
            {"person_share_95", or_null(found.person_share_95)},
            {"ground_m_95", or_null(found.ground_m_95)},
            {"ground", ground},
            {"click_px", found.click_px},
            {"click_is_stated", found.is_click_stated},
            {"degrees_of_freedom", found.degrees_of_freedom},
            {"rms_px", found.rms_px},
            {"residuals", std::move(residuals)},
            {"covariance", {{"of", std::move(names)}, {"rows", std::move(rows)}, {"region_95", found.region_95}}}};
}

Result<json> calibration_json(const PlateTask& task, const std::optional<KnownCamera>& known) {
    if (known && known->pose && task.points.empty() && task.heights.empty() && task.lines.empty()) {
        const auto lens = camera::LensMap::create(known->lens);
        if (!lens) return std::unexpected(lens.error());
        return json{{"camera", camera_json(known->size, known->intrinsics, known->lens, *known->pose)},
                    {"verdict", "unknown"},
                    {"reason", "unknown: as the file has it; give points to see how far it is off"},
                    {"ground", ground_json({.k = known->intrinsics,
                                            .lens = *lens,
                                            .world_from_optical = camera::world_from_optical_rotation(*known->pose),
                                            .position = known->pose->position},
                                           known->size)}};
    }
    const auto found = calibrate_plate(task);
    if (!found) return std::unexpected(found.error());
    return to_json(*found);
}

json light_json(const PlateLight& light, const glm::dvec3& direction, double north) {
    const daylight::SunPlace sun = daylight::sun_of(direction, north);
    const double intensity = std::max({light.sun.r, light.sun.g, light.sun.b});
    return {{"azimuth_deg", glm::degrees(sun.azimuth)},
            {"elevation_deg", glm::degrees(sun.elevation)},
            {"lights", json::array({{{"type", "directional"},
                                     {"name", "sun"},
                                     {"direction", vector_json(direction)},
                                     {"color", vector_json(light.sun / intensity)},
                                     {"intensity", intensity}}})},
            {"environment", {{"ambient", {{"sky", vector_json(light.sky)}, {"ground", vector_json(light.ground)}}}}}};
}

Result<PlateView> read_camera(const json& value, const std::string& path, ImageSize* size) {
    // A camera has more keys, which say nothing of where a pixel looks.
    json needed = json::object();
    for (const char* key : {"size", "intrinsics", "vfov_deg", "lens", "pose"})
        if (value.is_object() && value.contains(key)) needed[key] = value[key];
    if (needed.contains("lens") && needed["lens"].is_object())
        for (const char* key : {"method", "filter"}) needed["lens"].erase(key);
    JsonReader reader(needed, path);
    *size = read_size(reader, std::nullopt);
    PlateView view;
    if (reader.ok()) {
        const auto k = read_intrinsics(reader, *size);
        if (k)
            view.k = *k;
        else
            reader.fail("intrinsics", "are missing; give them or vfov_deg");
    }
    const camera::Lens lens = read_lens(reader);
    const json* const pose_value = reader.find("pose");
    if (!pose_value) reader.fail("pose", "is missing");
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    JsonReader keys(*pose_value, path + ".pose");
    std::array<double, 3> at{}, target{};
    std::array<double, 4> turn{0, 0, 0, 1};
    camera::PanTiltRoll angles;
    keys.required("position", std::span<double>(at));
    const bool looks_at = keys.has("look_at"), is_turned = keys.has("orientation");
    if (looks_at) keys.required("look_at", std::span<double>(target));
    if (is_turned) keys.required("orientation", std::span<double>(turn));
    keys.optional("pan_deg", angles.pan);
    keys.optional("tilt_deg", angles.tilt);
    keys.optional("roll_deg", angles.roll);
    if (auto done = keys.finish(); !done) return std::unexpected(done.error());
    const glm::dvec3 position(at[0], at[1], at[2]);
    const auto pose =
        looks_at    ? camera::pose_look_at(position, {target[0], target[1], target[2]})
        : is_turned ? camera::pose_from_quaternion(position, glm::dquat(turn[3], turn[0], turn[1], turn[2]))
                    : camera::pose_from_angles(
                          position, {glm::radians(angles.pan), glm::radians(angles.tilt), glm::radians(angles.roll)});
    if (!pose) return camrig::at(path, pose.error());
    auto map = camera::LensMap::create(lens);
    if (!map) return camrig::at(path + ".lens", map.error());
    view.lens = *map;
    view.position = pose->position;
    view.world_from_optical = camera::world_from_optical_rotation(*pose);
    return view;
}

}  // namespace camrig::photo
