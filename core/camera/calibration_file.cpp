#include "core/camera/calibration_file.h"

#include <cstdio>
#include <initializer_list>
#include <memory>
#include <tuple>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/camera/calibration_values.h"
#include "core/camera/camera_model.h"
#include "core/camera/kalibr_camchain.h"
#include "core/camera/yaml_document.h"

namespace camrig::camera {
namespace {

using nlohmann::json;

/// OpenCV's longest list: 8 rational, 4 thin prism, 2 tilt.
constexpr std::size_t max_opencv_coefficients = 14;

/// The value of the first of these keys that is there; its name in `found`.
const json* find_any(const json& object, std::initializer_list<const char*> keys, std::string* found) {
    for (const char* key : keys) {
        const auto it = object.find(key);
        if (it == object.end()) continue;
        *found = key;
        return &*it;
    }
    return nullptr;
}

/// The numbers of {rows, cols, data} (ROS and FileStorage alike); the count must be rows * cols.
Result<std::vector<double>> matrix(const json& value, const std::string& key, std::size_t max_count) {
    if (!value.is_object()) return bad_value(key, "must be a matrix with rows, cols and data");
    for (const char* field : {"rows", "cols", "data"})
        if (!value.contains(field)) return bad_value(key, std::string("has no ") + field);
    const auto rows = whole_number_value(value["rows"], key + ".rows", 0, 100);
    if (!rows) return std::unexpected(rows.error());
    const auto cols = whole_number_value(value["cols"], key + ".cols", 0, 100);
    if (!cols) return std::unexpected(cols.error());
    const auto count = static_cast<std::size_t>(*rows) * static_cast<std::size_t>(*cols);
    if (count > max_count)
        return bad_value(key, "is " + std::to_string(*rows) + "x" + std::to_string(*cols) + "; at most " +
                                  std::to_string(max_count) + " numbers make sense here");
    return number_list(value["data"], key + ".data", count, count);
}

Result<Intrinsics> intrinsics_from_matrix(const json& value, const std::string& key) {
    const auto k = matrix(value, key, 9);
    if (!k) return std::unexpected(k.error());
    if (k->size() != 9) return bad_value(key, "must be 3x3");
    const auto& m = *k;
    if (m[1] != 0.0)
        return bad_value(key, "has a skew; square or rectangular pixels only (the second number must be 0)");
    if (m[3] != 0.0 || m[6] != 0.0 || m[7] != 0.0 || m[8] != 1.0)
        return bad_value(key, "must be [fx, 0, cx, 0, fy, cy, 0, 0, 1]");
    return Intrinsics{m[0], m[4], m[2], m[5]};
}

Result<Lens> lens_of_model(LensModel model, std::vector<double> k, const std::string& key) {
    if (model == LensModel::plumb_bob) {
        if (k.size() != 4 && k.size() != 5)
            return bad_value(key, "plumb_bob takes 5 numbers (k1 k2 p1 p2 k3), not " + std::to_string(k.size()));
        return lens_from_opencv(std::move(k), key);
    }
    if (model == LensModel::rational_polynomial) {
        if (k.size() < 8)
            return bad_value(
                key, "rational_polynomial takes 8 numbers (k1 k2 p1 p2 k3 k4 k5 k6), not " + std::to_string(k.size()));
        return lens_from_opencv(std::move(k), key);
    }
    auto lens = make_lens(model, k);
    if (!lens) return at(key, lens.error());
    return lens;
}

Result<ImageSize> size_from(const json& root, const CalibrationQuery& query) {
    if (!root.contains("image_width") && !root.contains("image_height")) {
        if (query.size) return *query.size;
        return bad_value("image_width", "is missing, so the size of the picture is not known; give it");
    }
    ImageSize size;
    for (const auto& [key, out, high] : {std::tuple("image_width", &size.width, max_image_size.width),
                                         std::tuple("image_height", &size.height, max_image_size.height)}) {
        if (!root.contains(key)) return bad_value(key, "is missing");
        const auto value = whole_number_value(root[key], key, 1, high);
        if (!value) return std::unexpected(value.error());
        *out = *value;
    }
    return size;
}

/// A file written for one part of the sensor, or for joined pixels, is for another picture than its size says.
Result<void> check_whole_sensor(const json& root) {
    for (const char* key : {"binning_x", "binning_y"}) {
        if (!root.contains(key)) continue;
        const auto binning = whole_number_value(root[key], key, 0, 1000);
        if (!binning) return std::unexpected(binning.error());
        if (*binning > 1)
            return error(ErrorKind::unsupported, std::string(key) + ": give the calibration of the binned picture");
    }
    if (!root.contains("roi") || !root["roi"].is_object()) return {};
    for (const char* key : {"x_offset", "y_offset"}) {
        if (!root["roi"].contains(key)) continue;
        const auto offset = whole_number_value(root["roi"][key], std::string("roi.") + key, 0, max_image_size.width);
        if (!offset) return std::unexpected(offset.error());
        if (*offset != 0)
            return error(ErrorKind::unsupported,
                         std::string("roi.") + key + ": give the calibration of the cropped picture");
    }
    return {};
}

/// ROS camera_info and OpenCV FileStorage share their shape; ROS says distortion_model, OpenCV (at most) fisheye_model.
Result<Calibration> parse_matrices(const json& root, const CalibrationQuery& query) {
    std::string key, distortion_key;
    const json* k = nullptr;
    const json* d = nullptr;
    if (query.camera == "1" || query.camera == "2") {
        const std::string m = "M" + query.camera, n = "D" + query.camera;
        k = find_any(root, {m.c_str()}, &key);
        d = find_any(root, {n.c_str()}, &distortion_key);
        if (!k) return bad_value(m, "is missing");
    } else {
        k = find_any(root, {"camera_matrix", "cameraMatrix", "Camera_Matrix", "K"}, &key);
        d = find_any(root, {"distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs", "D"},
                     &distortion_key);
        if (!k && root.contains("M1")) return bad_value("M1", "this is a stereo pair; say which camera: 1 or 2");
        if (!k) return bad_value("camera_matrix", "is missing");
    }
    if (auto whole = check_whole_sensor(root); !whole) return std::unexpected(whole.error());
    Calibration out;
    const auto intrinsics = intrinsics_from_matrix(*k, key);
    if (!intrinsics) return std::unexpected(intrinsics.error());
    out.intrinsics = *intrinsics;
    const auto size = size_from(root, query);
    if (!size) return std::unexpected(size.error());
    out.size = *size;
    if (root.contains("camera_name") && root["camera_name"].is_string())
        out.camera_name = root["camera_name"].get<std::string>();

    std::vector<double> coefficients;
    if (d) {
        auto list = matrix(*d, distortion_key, max_opencv_coefficients);
        if (!list) return std::unexpected(list.error());
        coefficients = std::move(*list);
    }
    bool fisheye = false;
    if (root.contains("fisheye_model")) {
        const auto flag = whole_number_value(root["fisheye_model"], "fisheye_model", 0, 1);
        if (!flag) return std::unexpected(flag.error());
        fisheye = *flag == 1;
    }
    const bool named = root.contains("distortion_model") && root["distortion_model"].is_string();
    Result<Lens> lens = error(ErrorKind::internal, "");
    if (named) {
        const auto model = parse_name<LensModel>(root["distortion_model"].get<std::string>());
        if (!model) return at("distortion_model", model.error());
        lens = lens_of_model(*model, std::move(coefficients),
                             distortion_key.empty() ? "distortion_coefficients" : distortion_key);
    } else if (fisheye) {
        lens = lens_of_model(LensModel::equidistant, std::move(coefficients), distortion_key);
    } else {
        lens = lens_from_opencv(std::move(coefficients), distortion_key);
    }
    if (!lens) return std::unexpected(lens.error());
    out.lens = *lens;
    return out;
}

Result<Calibration> parse_any(std::string_view text, const CalibrationQuery& query) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    if (text.substr(0, text.find_first_not_of(" \t\r\n") + 1).ends_with('<')) {
        return error(ErrorKind::unsupported, "is XML; FileStorage XML is not read, write the file as .yml or .json");
    }
    const auto root = parse_yaml(text);
    if (!root) return std::unexpected(root.error());
    if (!root->is_object()) return error(ErrorKind::invalid_argument, "holds no keys; it is no calibration");
    return is_kalibr_camchain(*root) ? parse_kalibr_camchain(*root, query) : parse_matrices(*root, query);
}

}  // namespace

Result<Calibration> parse_calibration(std::string_view text, std::string_view source, const CalibrationQuery& query) {
    auto calibration = parse_any(text, query);
    if (!calibration) return at(source, calibration.error());
    if (query.size && calibration->size != *query.size) {
        return error(ErrorKind::invalid_argument,
                     std::string(source) + ": is for pictures of " + calibration->size.to_string() + ", not " +
                         query.size->to_string() + "; a calibration holds for one size only");
    }
    const auto camera = CameraModel::create(calibration->size, calibration->intrinsics, calibration->lens);
    if (!camera) return at(source, camera.error());
    return calibration;
}

Result<Calibration> read_calibration_file(const std::string& path, const CalibrationQuery& query) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
    if (!file) return error(ErrorKind::not_found, path + ": cannot be opened");
    std::string text(max_yaml_bytes + 1, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), file.get()));
    if (std::ferror(file.get())) return error(ErrorKind::unavailable, path + ": cannot be read");
    return parse_calibration(text, path, query);
}

}  // namespace camrig::camera
