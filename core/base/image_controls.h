#pragma once

#include <optional>

#include "core/base/result.h"

namespace camrig {

/// What the electronics of a camera do to its finished picture, as the controls of a real one do. The values one has
/// at the start change nothing and cost nothing.
struct ImageControls {
    bool auto_exposure = true;       ///< the scene's exposure; exposure_ev waits
    double exposure_ev = 0;          ///< -6..6: light is multiplied by 2^ev; what the renderer clipped stays clipped
    double gain_db = 0;              ///< 0..24: light is multiplied by 10^(dB/20)
    bool auto_white_balance = true;  ///< neutral; white_balance_k waits
    double white_balance_k = 6500;   ///< 2800..10000: the light that is taken for white; lower makes bluer pictures
    double brightness = 0;           ///< -1..1, added to sRGB codes (1 = from black to white)
    double contrast = 1;             ///< 0..2, of sRGB codes about the middle
    double saturation = 1;           ///< 0..2; 0 is grey
    friend bool operator==(const ImageControls&, const ImageControls&) = default;
};

/// Changes to some of them.
struct ImageControlsPatch {
    std::optional<bool> auto_exposure;
    std::optional<double> exposure_ev;
    std::optional<double> gain_db;
    std::optional<bool> auto_white_balance;
    std::optional<double> white_balance_k;
    std::optional<double> brightness;
    std::optional<double> contrast;
    std::optional<double> saturation;
};

void apply_controls(const ImageControlsPatch& patch, ImageControls& controls);

/// The first value out of its range is named ("controls.gain_db: must be 0 to 24").
Result<void> check_controls(const ImageControls& controls);

}  // namespace camrig
