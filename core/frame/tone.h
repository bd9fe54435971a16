#pragma once

#include <cstddef>
#include <span>

#include "core/base/image_controls.h"

namespace camrig::frame {

/// True when apply_tone() would change no pixel.
bool changes_nothing(const ImageControls& controls);

/// Applies a camera's image controls to an rgba8 picture, in place; alpha stays. First what acts on light (exposure,
/// gain, white balance: one factor per channel on linear values, clipped at white), then contrast and brightness, then
/// saturation on sRGB codes, with the luma of BT.601. Each of the two steps rounds to 8 bits.
void apply_tone(std::span<std::byte> rgba, const ImageControls& controls);

}  // namespace camrig::frame
