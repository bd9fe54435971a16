#pragma once

#include <nlohmann/json.hpp>

#include "core/base/result.h"
#include "tools/camrig/cli_camera_options.h"
#include "tools/camrig/cli_context.h"

namespace camrig::cli {

/// `camera calibration NAME`.
void add_calibration_command(CLI::App& camera, CliContext& context);

/// --calibration: puts size, intrinsics and lens of a real camera into the parameters of camera.create or camera.set. A
/// size that is there already must be the file's. Does nothing when the option is not given.
Result<void> put_calibration(const CameraOptions& options, nlohmann::json& params);

}  // namespace camrig::cli
