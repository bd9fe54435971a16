#include "core/render/pixel_rect.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace camrig::render {
namespace {

/// Points and lines are a pixel wide, vertices snap to 1/256, samples lie half a pixel from the middle.
constexpr double slack_px = 2.0;
/// More rectangles than this are first joined by where they are: joining pairs looks at all of them.
constexpr std::size_t max_pairwise = 48;
constexpr int cells = 6;

PixelRect joined(const PixelRect& a, const PixelRect& b) {
    return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

std::vector<PixelRect> by_place(const std::vector<PixelRect>& rects) {
    PixelRect all = rects.front();
    for (const PixelRect& rect : rects) all = joined(all, rect);
    std::vector<std::optional<PixelRect>> places(cells * cells);
    for (const PixelRect& rect : rects) {
        const std::int64_t x = (rect.x0 + rect.x1) / 2 - all.x0, y = (rect.y0 + rect.y1) / 2 - all.y0;
        auto& place =
            places[static_cast<std::size_t>(y * cells / (all.height() + 1) * cells + x * cells / (all.width() + 1))];
        place = place ? joined(*place, rect) : rect;
    }
    std::vector<PixelRect> result;
    for (const auto& place : places)
        if (place) result.push_back(*place);
    return result;
}

}  // namespace

std::optional<PixelRect> screen_bounds(const ViewTransform& view, const glm::dmat4& optical_from_local,
                                       glm::vec3 box_min, glm::vec3 box_max) {
    glm::dvec2 low(std::numeric_limits<double>::infinity()), high(-low);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec4 local((corner & 1 ? box_max : box_min).x, (corner & 2 ? box_max : box_min).y,
                               (corner & 4 ? box_max : box_min).z, 1.0);
        const glm::dvec3 p(optical_from_local * local);
        if (!(p.z > view.near_m)) return PixelRect{0, 0, view.size.width, view.size.height};
        const glm::dvec2 pixel(view.intrinsics.fx * p.x / p.z + view.intrinsics.cx,
                               view.intrinsics.fy * p.y / p.z + view.intrinsics.cy);
        low = glm::min(low, pixel);
        high = glm::max(high, pixel);
    }
    // In double: far beside the picture, numbers are too large for an int.
    const auto inside = [](double value, int size) { return static_cast<int>(std::clamp(value, 0.0, double(size))); };
    const PixelRect rect{inside(std::floor(low.x - slack_px), view.size.width),
                         inside(std::floor(low.y - slack_px), view.size.height),
                         inside(std::ceil(high.x + slack_px) + 1.0, view.size.width),
                         inside(std::ceil(high.y + slack_px) + 1.0, view.size.height)};
    if (rect.width() <= 0 || rect.height() <= 0) return std::nullopt;
    return rect;
}

std::vector<PixelRect> disjoint_cover(std::vector<PixelRect> rects, std::size_t max_count) {
    if (rects.size() > max_pairwise) rects = by_place(rects);
    while (rects.size() > 1) {
        std::size_t first = 0, second = 0;
        std::int64_t least = std::numeric_limits<std::int64_t>::max();
        bool must_join = rects.size() > max_count;
        for (std::size_t i = 0; i < rects.size(); ++i) {
            for (std::size_t j = i + 1; j < rects.size(); ++j) {
                const bool intersect = rects[i].intersects(rects[j]);
                const std::int64_t waste = intersect
                                               ? std::numeric_limits<std::int64_t>::min()
                                               : joined(rects[i], rects[j]).area() - rects[i].area() - rects[j].area();
                must_join |= intersect;
                if (waste < least) {
                    least = waste;
                    first = i;
                    second = j;
                }
            }
        }
        if (!must_join) break;
        rects[first] = joined(rects[first], rects[second]);
        rects.erase(rects.begin() + static_cast<std::ptrdiff_t>(second));
    }
    return rects;
}

}  // namespace camrig::render
