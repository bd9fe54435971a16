#include "core/world/backdrop/triangulate.h"

#include <algorithm>
#include <numeric>

namespace camrig::world {
namespace {

/// Twice the area of a triangle; positive: counter-clockwise.
double twice_area(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool do_cross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
    return twice_area(a, b, c) * twice_area(a, b, d) < 0.0 && twice_area(c, d, a) * twice_area(c, d, b) < 0.0;
}

}  // namespace

Result<std::vector<std::array<std::uint32_t, 3>>> triangles_of(std::span<const glm::dvec2> polygon) {
    const std::size_t count = polygon.size();
    if (count < 3) return error(ErrorKind::invalid_argument, "a polygon has at least 3 corners");
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t k = i + 2; k < count; ++k)
            if (do_cross(polygon[i], polygon[i + 1], polygon[k], polygon[(k + 1) % count]))
                return error(ErrorKind::invalid_argument, "the polygon crosses itself: the sides from corners " +
                                                              std::to_string(i) + " and " + std::to_string(k));
    double area = 0.0;
    for (std::size_t i = 1; i + 1 < count; ++i) area += twice_area(polygon[0], polygon[i], polygon[i + 1]);
    std::vector<std::uint32_t> left(count);
    std::iota(left.begin(), left.end(), 0u);
    if (area < 0.0) std::ranges::reverse(left);
    std::vector<std::array<std::uint32_t, 3>> triangles;
    // Cuts off one corner after the other whose triangle holds no other corner.
    for (std::size_t i = 0, tried = 0; left.size() >= 3 && tried <= left.size();) {
        const std::size_t n = left.size();
        const std::uint32_t a = left[(i + n - 1) % n], b = left[i % n], c = left[(i + 1) % n];
        const double size = twice_area(polygon[a], polygon[b], polygon[c]);
        const bool is_ear = size >= 0.0 && std::ranges::none_of(left, [&](std::uint32_t k) {
                                if (k == a || k == b || k == c || size == 0.0) return false;
                                const glm::dvec2& p = polygon[k];
                                return twice_area(polygon[a], polygon[b], p) >= 0.0 &&
                                       twice_area(polygon[b], polygon[c], p) >= 0.0 &&
                                       twice_area(polygon[c], polygon[a], p) >= 0.0;
                            });
        if (!is_ear) {
            i = (i + 1) % n;
            ++tried;
            continue;
        }
        if (size > 0.0) triangles.push_back({a, b, c});
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(i % n));
        i = left.empty() ? 0 : i % left.size();
        tried = 0;
    }
    if (triangles.empty()) return error(ErrorKind::invalid_argument, "the polygon has no area");
    if (left.size() >= 3) return error(ErrorKind::invalid_argument, "the polygon crosses or touches itself");
    return triangles;
}

}  // namespace camrig::world
