#pragma once

#include <Eigen/Core>

#include "core/base/result.h"
#include "core/photo/plate_model.h"

namespace camrig::photo {

/// Fills covariance, region and half widths of a calibration whose click_px, is_click_stated and degrees_of_freedom are
/// there already, and what they mean for people. Error invalid_argument: the clicks leave something undetermined; it
/// says what.
Result<void> find_uncertainty(const PlateModel& model, const PlateState& state, PlateCalibration& calibration);

}  // namespace camrig::photo
