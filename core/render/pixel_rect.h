#pragma once

#include <optional>
#include <vector>

#include "core/base/pixel_rect.h"
#include "core/render/view_transform.h"

namespace camrig::render {

/// Every pixel that something inside the box may touch, and a little more; the whole picture for a box that reaches
/// the near plane; nothing for one that lies beside the picture.
std::optional<PixelRect> screen_bounds(const ViewTransform& view, const glm::dmat4& optical_from_local,
                                       glm::vec3 box_min, glm::vec3 box_max);

/// Rectangles of which no two intersect, covering all that the given ones cover, at most max_count. Those are joined
/// that waste least.
std::vector<PixelRect> disjoint_cover(std::vector<PixelRect> rects, std::size_t max_count);

}  // namespace camrig::render
