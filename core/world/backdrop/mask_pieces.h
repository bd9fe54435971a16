#pragma once

#include <vector>

#include "core/base/pixel_rect.h"
#include "core/base/result.h"
#include "core/world/model.h"

namespace camrig::world {

/// What a mask marks, in rectangles of at most 16 by 16 pixels that do not overlap: where its alpha is at least half
/// or, if it is opaque everywhere, where it is at least half as light as white. Errors: nothing is marked, or it is so
/// ragged that it takes more than 65536 rectangles.
Result<std::vector<PixelRect>> mask_pieces(const Image& mask);

}  // namespace camrig::world
