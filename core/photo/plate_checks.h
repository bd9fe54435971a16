#pragma once

#include <cstdio>
#include <string>

#include "core/base/result.h"
#include "core/photo/plate_model.h"

namespace camrig::photo {

/// For messages: three digits.
inline std::string short_number(double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", number);
    return text;
}

/// What can be said before anything is sought.
Result<void> check_plate_task(const PlateModel& model);

/// Clicks that do not fit: which of them is to blame, if one is. `click_px`: what the residuals make of a click.
Error contradiction(const PlateModel& model, const PlateFit& best, double click_px);

/// The point that does not fit while all others do, far better than with it; -1: there is none.
struct Outlier {
    int point = -1;
    double off_px = 0.0;        ///< from where the others have it
    double others_px = 0.0;     ///< what a click is of the others
    bool over_horizon = false;  ///< of the ground at its height
};
Outlier find_outlier(const PlateModel& model, double click_px);

}  // namespace camrig::photo
