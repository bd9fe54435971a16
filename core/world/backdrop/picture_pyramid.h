#pragma once

#include <vector>

#include "core/world/model.h"

namespace camrig::world {

/// A picture in many sizes, for what is drawn smaller than it is. Immutable.
struct PicturePyramid {
    /// The picture itself, then halves of it down to a few pixels, each the mean in linear light. A third more memory.
    std::vector<Image> levels;
};

PicturePyramid make_pyramid(Image picture);

}  // namespace camrig::world
