#include "tools/camrig/cli_calibration.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include <CLI/CLI.hpp>

#include "core/base/write_file.h"
#include "core/camera/calibration_file.h"
#include "core/camera/lens_traits.h"
#include "core/world/camera_json.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

/// The calibration of a camera as camera.get shows it.
Result<camera::Calibration> calibration_of(const json& camera) {
    JsonReader reader(camera, "camera.get");
    camera::Calibration calibration;
    reader.required("name", calibration.camera_name);
    const world::CameraPatch patch = world::read_camera_patch(reader);
    if (!reader.ok()) return std::unexpected(reader.finish().error());
    const auto* intrinsics = patch.optics ? std::get_if<camera::Intrinsics>(&*patch.optics) : nullptr;
    if (!patch.size || !intrinsics || !patch.lens)
        return error(ErrorKind::internal, "camera.get: the answer has no size, intrinsics or lens");
    calibration.size = *patch.size;
    calibration.intrinsics = *intrinsics;
    calibration.lens = *patch.lens;
    return calibration;
}

/// Where a ROS driver looks for it unasked: $ROS_HOME/camera_info/NAME.yaml, ROS_HOME by default ~/.ros.
Result<std::filesystem::path> ros_folder() {
    const char* ros_home = std::getenv("ROS_HOME");
    if (ros_home && *ros_home) return std::filesystem::path(ros_home) / "camera_info";
    const char* home = std::getenv("HOME");
    if (!home || !*home)
        return error(ErrorKind::invalid_argument, "--ros: neither ROS_HOME nor HOME is set; give -o FILE");
    return std::filesystem::path(home) / ".ros" / "camera_info";
}

struct CalibrationOptions {
    std::string camera;
    std::filesystem::path file;
    bool ros = false;
};

int write_calibration(const CliContext& context, const CalibrationOptions& options) {
    auto camera = context.call("camera.get", {{"name", options.camera}});
    if (!camera) return context.fail(camera.error());
    const auto calibration = calibration_of(*camera);
    if (!calibration) return context.fail(calibration.error());
    const auto yaml = write_camera_info(*calibration);
    if (!yaml) return context.fail(yaml.error());
    std::filesystem::path file = options.file;
    std::error_code problem;
    if (options.ros) {
        const auto folder = ros_folder();
        if (!folder) return context.fail(folder.error());
        std::filesystem::create_directories(*folder, problem);
        if (problem)
            return context.fail({ErrorKind::unavailable, folder->string() + ": cannot be made: " + problem.message()});
        file = *folder;
    }
    if (file.empty()) return context.print({{"yaml", *yaml}}, *yaml);
    if (std::filesystem::is_directory(file, problem)) file /= options.camera + ".yaml";
    if (auto written = write_atomically(file, std::as_bytes(std::span(*yaml))); !written)
        return context.fail(written.error());
    return context.print({{"file", file.string()}}, file.string() + ": the calibration of " + options.camera);
}

}  // namespace

Result<void> put_calibration(const CameraOptions& options, json& params) {
    if (options.calibration.empty()) return {};
    camera::CalibrationQuery query{.camera = options.calibration_camera, .size = std::nullopt};
    if (params.contains("size")) query.size = ImageSize{params["size"][0].get<int>(), params["size"][1].get<int>()};
    const auto calibration = read_calibration_file(options.calibration, query);
    if (!calibration) return at("--calibration", calibration.error());
    const auto& [fx, fy, cx, cy] = calibration->intrinsics;
    // ROS has no name for a pinhole and writes plumb_bob with zeros; here it has one.
    const camera::Lens lens = is_plain(calibration->lens) ? camera::Lens{} : calibration->lens;
    const auto& k = lens.coefficients;
    params["size"] = {calibration->size.width, calibration->size.height};
    params["intrinsics"] = {{"fx", fx}, {"fy", fy}, {"cx", cx}, {"cy", cy}};
    params["lens"] = {{"model", to_string(lens.model)},
                      {"coefficients", std::vector<double>(k.begin(), k.begin() + coefficient_count(lens.model))}};
    return {};
}

void add_calibration_command(CLI::App& camera, CliContext& context) {
    auto options = std::make_shared<CalibrationOptions>();
    CLI::App* command = camera.add_subcommand(
        "calibration", "prints a camera's calibration as ROS camera_info YAML, or writes it to a file");
    command->add_option("NAME", options->camera, "the camera")->required();
    auto* file = command->add_option("-o,--output", options->file, "FILE, or a folder: NAME.yaml in it");
    command->add_flag("--ros", options->ros, "where ROS drivers look: $ROS_HOME/camera_info/NAME.yaml (~/.ros)")
        ->excludes(file);
    command->callback(
        [options, &context] { context.action = [options, &context] { return write_calibration(context, *options); }; });
}

}  // namespace camrig::cli
