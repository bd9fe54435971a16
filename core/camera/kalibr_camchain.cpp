#include "core/camera/kalibr_camchain.h"

#include <cmath>

#include "core/camera/calibration_values.h"
#include "core/camera/lens_map.h"

namespace camrig::camera {
namespace {

using nlohmann::json;

/// Cameras named in a message; a file may hold thousands.
constexpr int max_names_shown = 16;

bool is_kalibr_camera(const std::string& key, const json& value) {
    return key.starts_with("cam") && value.is_object() && value.contains("intrinsics");
}

Result<Calibration> parse_kalibr_camera(const json& camera, const std::string& name) {
    if (!camera.is_object()) return bad_value(name, "must be a camera");
    const auto text = [&](const char* key) {
        return camera.contains(key) && camera[key].is_string() ? camera[key].get<std::string>() : std::string();
    };
    for (const char* key : {"intrinsics", "resolution", "distortion_model"})
        if (!camera.contains(key)) return bad_value(name + "." + key, "is missing");
    if (text("camera_model") != "pinhole") {
        return error(ErrorKind::unsupported, name +
                                                 ".camera_model: only pinhole is read (with distortion_model radtan, "
                                                 "equidistant or none); calibrate the camera with one of these");
    }
    const auto k = number_list(camera["intrinsics"], name + ".intrinsics", 4, 4);
    if (!k) return std::unexpected(k.error());
    const auto size = number_list(camera["resolution"], name + ".resolution", 2, 2);
    if (!size) return std::unexpected(size.error());
    for (const double side : *size)
        if (side != std::floor(side) || side < 1 || side > max_image_size.width)
            return bad_value(name + ".resolution", "must be [width, height] in pixels");
    Calibration out{
        name, {static_cast<int>((*size)[0]), static_cast<int>((*size)[1])}, {(*k)[0], (*k)[1], (*k)[2], (*k)[3]}, {}};

    const std::string model = text("distortion_model");
    const std::string key = name + ".distortion_coeffs";
    if (model == "none") return out;
    if (model != "radtan" && model != "equidistant")
        return error(ErrorKind::unsupported, name + ".distortion_model: only radtan, equidistant and none are read");
    if (!camera.contains("distortion_coeffs")) return bad_value(key, "is missing");
    const auto coefficients = number_list(camera["distortion_coeffs"], key, 4, 4);
    if (!coefficients) return std::unexpected(coefficients.error());
    const auto lens =
        model == "radtan" ? lens_from_opencv(*coefficients, key) : make_lens(LensModel::equidistant, *coefficients);
    if (!lens) return at(key, lens.error());
    out.lens = *lens;
    return out;
}

}  // namespace

bool is_kalibr_camchain(const json& root) {
    for (const auto& [key, value] : root.items())
        if (is_kalibr_camera(key, value)) return true;
    return false;
}

Result<Calibration> parse_kalibr_camchain(const json& root, const CalibrationQuery& query) {
    std::string names;
    const json* chosen = nullptr;
    std::string chosen_name;
    int cameras = 0;
    for (const auto& [key, value] : root.items()) {
        if (!is_kalibr_camera(key, value)) continue;
        const bool by_topic = value.contains("rostopic") && value["rostopic"] == query.camera;
        if (query.camera.empty() || key == query.camera || by_topic) {
            chosen = &value;
            chosen_name = key;
        }
        if (++cameras <= max_names_shown) names += (names.empty() ? "" : ", ") + key.substr(0, 24);
    }
    if (!chosen) return error(ErrorKind::not_found, "has no camera of that name; there are " + names);
    if (query.camera.empty() && cameras > 1)
        return error(ErrorKind::invalid_argument, "holds several cameras; say which: " + names);
    return parse_kalibr_camera(*chosen, chosen_name);
}

}  // namespace camrig::camera
