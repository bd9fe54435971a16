#pragma once

#include "core/base/field_table.h"

namespace camrig {

/// What the electronics of a camera do to its finished picture, as the controls of a real one do. The defaults change
/// nothing and cost nothing.
struct ImageControls {
    bool auto_exposure = true;  ///< on: exposure_ev has no effect
    double exposure_ev = 0;     ///< what the renderer clipped stays clipped
    double gain_db = 0;
    bool auto_white_balance = true;  ///< on: white_balance_k has no effect
    double white_balance_k = 6500;
    double brightness = 0;
    double contrast = 1;
    double saturation = 1;
    friend bool operator==(const ImageControls&, const ImageControls&) = default;
};

/// An exposure or a white balance that is given in JSON switches its automatic off, unless that is given too.
FieldTable<ImageControls> fields_of(std::type_identity<ImageControls>);

}  // namespace camrig
