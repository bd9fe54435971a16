#include <algorithm>
#include <charconv>
#include <vector>

#include "core/camera/calibration_file.h"
#include "core/camera/camera_model.h"

namespace camrig::camera {
namespace {

/// The shortest decimal that reads back as the same double. YAML 1.1 readers (PyYAML, so ROS's Python tools) take 2e-04
/// for text; 2.0e-04 is a number to all.
std::string shortest(double value) {
    char text[40];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    std::string out(text, end);
    const auto exponent = out.find('e');
    if (exponent != std::string::npos && out.find('.') == std::string::npos) out.insert(exponent, ".0");
    return out;
}

std::string matrix(const char* key, int rows, int cols, const std::vector<double>& data) {
    std::string out =
        std::string(key) + ":\n  rows: " + std::to_string(rows) + "\n  cols: " + std::to_string(cols) + "\n  data: [";
    for (std::size_t i = 0; i < data.size(); ++i) out += (i ? ", " : "") + shortest(data[i]);
    return out + "]\n";
}

bool is_ros_name(std::string_view name) {
    return !name.empty() && std::ranges::all_of(name, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    });
}

}  // namespace

Result<std::string> write_camera_info(const Calibration& c) {
    if (!is_ros_name(c.camera_name))
        return error(ErrorKind::invalid_argument, "camera_name: ROS takes letters, digits and _ only");
    if (auto camera = CameraModel::create(c.size, c.intrinsics, c.lens); !camera)
        return std::unexpected(camera.error());
    const LensModel model = c.lens.model == LensModel::pinhole ? LensModel::plumb_bob : c.lens.model;
    const int count = coefficient_count(model);
    const auto& [fx, fy, cx, cy] = c.intrinsics;
    std::string out;
    out += "image_width: " + std::to_string(c.size.width) + "\n";
    out += "image_height: " + std::to_string(c.size.height) + "\n";
    out += "camera_name: " + c.camera_name + "\n";
    out += matrix("camera_matrix", 3, 3, {fx, 0, cx, 0, fy, cy, 0, 0, 1});
    out += "distortion_model: " + std::string(to_string(model)) + "\n";
    out +=
        matrix("distortion_coefficients", 1, count, {c.lens.coefficients.begin(), c.lens.coefficients.begin() + count});
    out += matrix("rectification_matrix", 3, 3, {1, 0, 0, 0, 1, 0, 0, 0, 1});
    out += matrix("projection_matrix", 3, 4, {fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0});
    return out;
}

}  // namespace camrig::camera
