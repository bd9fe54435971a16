#pragma once

#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/base/image_size.h"

namespace camrig::bake {

/// Places rectangles of these sizes without overlap in an area of that size; nullopt: they do not fit.
std::optional<std::vector<glm::ivec2>> pack(std::span<const ImageSize> rects, ImageSize area);

/// The smallest area found that holds them, its sides multiples of four; nullopt beyond max_side.
struct PackedRects {
    ImageSize area;
    std::vector<glm::ivec2> places;
};
std::optional<PackedRects> pack_tightly(std::span<const ImageSize> rects, int max_side);

}  // namespace camrig::bake
