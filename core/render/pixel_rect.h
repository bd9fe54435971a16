#pragma once

#include <optional>
#include <vector>

#include "core/render/view_transform.h"

namespace camrig::render {

/// Pixels x0 <= x < x1, y0 <= y < y1.
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    int width() const { return x1 - x0; }
    int height() const { return y1 - y0; }
    std::int64_t area() const { return std::int64_t{width()} * height(); }
    bool intersects(const PixelRect& other) const {
        return x0 < other.x1 && other.x0 < x1 && y0 < other.y1 && other.y0 < y1;
    }
    friend bool operator==(const PixelRect&, const PixelRect&) = default;
};

/// Every pixel that something inside the box may touch, and a little more; the whole picture for a box that reaches
/// the near plane; nothing for one that lies beside the picture.
std::optional<PixelRect> screen_bounds(const ViewTransform& view, const glm::dmat4& optical_from_local,
                                       glm::vec3 box_min, glm::vec3 box_max);

/// Rectangles of which no two intersect, covering all that the given ones cover, at most max_count. Those are joined
/// that waste least.
std::vector<PixelRect> disjoint_cover(std::vector<PixelRect> rects, std::size_t max_count);

}  // namespace camrig::render
