#pragma once

#include <nlohmann/json.hpp>

#include "core/camera/calibration_file.h"

namespace camrig::camera {

/// Whether a document (of parse_yaml) looks like a Kalibr camchain: camN entries with intrinsics.
bool is_kalibr_camchain(const nlohmann::json& root);
/// One camera of it; see calibration_file.h.
Result<Calibration> parse_kalibr_camchain(const nlohmann::json& root, const CalibrationQuery& query);

}  // namespace camrig::camera
