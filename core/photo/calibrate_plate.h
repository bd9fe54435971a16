#pragma once

#include "core/base/result.h"
#include "core/photo/plate_task.h"

namespace camrig::photo {

/// Finds the camera of a photo by the least squares of its clicks, and how far it may be off (the inverse of the normal
/// matrix by the variance of a click; Hartley and Zisserman, Multiple View Geometry, 2nd edition, chapters 5 and 7).
/// Tens of milliseconds; what does not fit is tried with each point left out in turn, which takes that long for each.
///
/// invalid_argument, with the place in the task: numbers that are not finite, too little for what is sought, all in one
/// place or on a line, what the clicks do not determine (a focal length from a plane seen straight down), clicks that
/// contradict each other, over the horizon of the others, two places of the camera that fit as well.
Result<PlateCalibration> calibrate_plate(const PlateTask& task);

// What bounds the work of a search.
inline constexpr std::size_t max_plate_points = 256;
inline constexpr std::size_t max_plate_heights = 24;  ///< each is two unknowns more: where it stands
inline constexpr std::size_t max_plate_lines = 64;

}  // namespace camrig::photo
