#include "core/render/software/marked_pixels.h"

#include <algorithm>
#include <cmath>

#include "core/render/software/coverage.h"
#include "core/render/software/lanes.h"
#include "core/render/software/ray_pixels.h"
#include "core/render/software/rows.h"

namespace camrig::render::software {
namespace {

struct EdgeMarks {
    const ViewGeometry& geometry;
    PixelRect rect;
    Rows<float> depth;
    MarkedPixels& pixels;
    OutlineEdges* edges;
};

CAMRIG_LANES void remember(const EdgeMarks& marks, std::uint32_t& known, std::uint32_t number) {
    if (known == OutlineEdges::none) {
        known = number;
    } else if (known != OutlineEdges::several && !is_same_edge(marks.geometry, known, number)) {
        known = OutlineEdges::several;
    }
}

void mark_edge(const EdgeMarks& to, std::uint32_t number, float reach) {
    const auto [a, b] = ends_of_edge(to.geometry, number);
    const ScreenVertex &top = a->y < b->y ? *a : *b, &bottom = a->y < b->y ? *b : *a;
    const PixelRect& rect = to.rect;
    constexpr int half = subpixels / 2;
    const int y0 = std::max(rect.y0, (top.y + half) >> 8), y1 = std::min(rect.y1 - 1, (bottom.y + half) >> 8);
    if (y0 > y1) return;
    const double height = bottom.y - top.y, scale = height > 0.0 ? 1.0 / height : 0.0;
    const double width = bottom.x - top.x, deeper = static_cast<double>(bottom.depth) - static_cast<double>(top.depth);
    const auto ends_in = [](const ScreenVertex& end, int x, int y) {
        return (end.x + half) >> 8 == x && (end.y + half) >> 8 == y;
    };
    for (int y = y0; y <= y1; ++y) {
        const double from = std::max(0.0, (y * subpixels - half - top.y) * scale);
        const double till = height > 0.0 ? std::min(1.0, (y * subpixels + half - top.y) * scale) : 1.0;
        const double xa = top.x + width * from, xb = top.x + width * till;
        const double za = top.depth + deeper * from, zb = top.depth + deeper * till;
        constexpr double slack = half + 0.5;  // of rounding
        const int x0 =
            std::max<int>(rect.x0, static_cast<int>(std::floor((std::min(xa, xb) + slack - 1.0) / subpixels)));
        const int x1 = std::min<int>(rect.x1 - 1, static_cast<int>(std::floor((std::max(xa, xb) + slack) / subpixels)));
        const float nearest = static_cast<float>(std::max(za, zb)) + reach;
        const float* const shown = to.depth(y);
        std::uint64_t* const marks = to.pixels.row(y);
        for (int x = x0; x <= x1; ++x) {
            const bool is_seen = nearest >= shown[x] * hidden_below;
            marks[x / MarkedPixels::word_bits] |= std::uint64_t{is_seen} << (x % MarkedPixels::word_bits);
            if (to.edges == nullptr) continue;
            if (is_seen) {
                // One that ends in a pixel does not divide it.
                std::uint32_t& known = to.edges->numbers()(y)[x];
                remember(to, known, number);
                if (ends_in(top, x, y) || ends_in(bottom, x, y)) known = OutlineEdges::several;
            } else {
                float& hidden = to.edges->hidden()(y)[x];
                hidden = std::max(hidden, nearest);
            }
        }
    }
}

/// Marks what the outline of a triangle touches through a lens, eight pixels at a time.
template <typename Isa>
CAMRIG_LANES void mark_ray_outline(const EdgeMarks& to, const RayTriangle& triangle, unsigned outline,
                                   const PixelRect& box) {
    constexpr float half = 0.5f;
    const LensRays& rays = *to.geometry.rays();
    const float farthest = to.geometry.farthest();
    const IntLanes from = int_lane_numbers();
    const auto visit_part = [&](const PixelRect& part) __attribute__((always_inline)) {
        for (int y = part.y0; y < part.y1; ++y) {
            const float* const shown = to.depth(y);
            std::uint64_t* const marks = to.pixels.row(y);
            for (int x = part.x0 & -lane_count; x < part.x1; x += lane_count) {
                const Lanes3 ray = rays_at(rays, x, y);
                const Lanes3 dx = rays_at(rays, x + 1, y) - ray, dy = rays_at(rays, x, y + 1) - ray;
                const auto reach = [&](const glm::vec3& of) __attribute__((always_inline)) {
                    const Lanes across = along(of, dx), down = along(of, dy);
                    return (max(across, -across) + max(down, -down)) * half;
                };
                IntLanes touched = ((from + (x - part.x0)) | ((part.x1 - 1 - x) - from)) >= 0;
                IntLanes has_edge{};
                for (std::size_t i = 0; i < 3; ++i) {
                    const Lanes value = along(triangle.edges[i], ray), slack = reach(triangle.edges[i]);
                    touched &= value >= -slack;
                    if ((outline >> i & 1) != 0) has_edge |= value <= slack;
                }
                const Lanes depth = along(triangle.depth, ray) + farthest, nearest = depth + reach(triangle.depth);
                const Lanes seen = *reinterpret_cast<const Lanes*>(shown + x) * hidden_below;
                touched &= has_edge & (nearest > 0.0f) & (nearest >= seen) & (depth <= 1.0f);
                const std::uint64_t bits = Isa::bits(touched);
                marks[x / MarkedPixels::word_bits] |= bits << (x % MarkedPixels::word_bits);
            }
        }
    };
    each_touched_part<Isa>(rays, triangle, farthest, outline, box, visit_part);
}

template <typename Isa>
CAMRIG_LANES void mark_ray_outlines_body(const EdgeMarks& to, std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t number = first; number < first + count; ++number) {
        const ScreenTriangle& triangle = to.geometry.triangles()[number];
        const PixelRect box = touched_by(triangle, to.rect);
        if (triangle.outline == 0 || box.width() <= 0 || box.height() <= 0) continue;
        mark_ray_outline<Isa>(to, to.geometry.ray_triangles()[number], triangle.outline, box);
    }
}
CAMRIG_WIDE void mark_ray_outlines_wide(const EdgeMarks& to, std::uint32_t first, std::uint32_t count) {
    mark_ray_outlines_body<Avx2Isa>(to, first, count);
}

/// The bits of pixels x0 <= x < x1 in a word of a row.
std::uint64_t bits_between(int word, int x0, int x1) {
    const int low = std::clamp(x0 - word * MarkedPixels::word_bits, 0, MarkedPixels::word_bits);
    const int high = std::clamp(x1 - word * MarkedPixels::word_bits, 0, MarkedPixels::word_bits);
    const auto below = [](int bit) { return bit == MarkedPixels::word_bits ? ~0ull : (1ull << bit) - 1; };
    return below(high) & ~below(low);
}

template <typename Isa>
CAMRIG_LANES void mark_crossings_body(const ViewGeometry& geometry, const PixelRect& rect, const MarkedPixels& outlines,
                                      const TriangleNumbers& numbers, std::uint32_t last_other, MarkedPixels& to) {
    const Rows<std::uint32_t> rows = numbers.rows();
    const ScreenTriangle* const triangles = geometry.triangles().data();
    const auto surface = [&](std::uint32_t number) {
        return number <= last_other ? -1 : static_cast<int>(triangles[number - 1].draw);
    };
    // A pixel and the one to the right of it or below; both lie in rows that are known.
    const auto look_at = [&](int x, int y, int dx, int dy) {
        const std::uint32_t own = rows(y)[x], other = rows(y + dy)[x + dx];
        if (surface(own) == surface(other) || outlines.has(x, y) || outlines.has(x + dx, y + dy)) return;
        if (rect.x0 <= x && rect.y0 <= y) to.set(x, y);
        if (x + dx < rect.x1 && y + dy < rect.y1) to.set(x + dx, y + dy);
    };
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int word = rect.x0 / MarkedPixels::word_bits; word * MarkedPixels::word_bits < rect.x1; ++word)
            to.row(y)[word] |= outlines.row(y)[word] & bits_between(word, rect.x0, rect.x1);
    }
    const PixelRect whole = geometry.whole();
    const int x_end = std::min(rect.x1, whole.x1 - 1);
    const auto look_along = [&](int y, int dx, int dy) __attribute__((always_inline)) {
        const std::uint32_t *const own = rows(y), *const other = rows(y + dy) + dx;
        const int from = dx > 0 ? std::max(rect.x0 - 1, 0) : rect.x0, till = dx > 0 ? x_end : rect.x1;
        int x = from;
        for (; x + lane_count <= till; x += lane_count) {
            for (unsigned left = Isa::bits(load_lanes(own + x) != load_lanes(other + x)); left != 0; left &= left - 1)
                look_at(x + std::countr_zero(left), y, dx, dy);
        }
        for (; x < till; ++x) {
            if (own[x] != other[x]) look_at(x, y, dx, dy);
        }
    };
    for (int y = rect.y0; y < rect.y1; ++y) look_along(y, 1, 0);
    for (int y = std::max(rect.y0 - 1, 0); y < std::min(rect.y1, whole.y1 - 1); ++y) look_along(y, 0, 1);
}

CAMRIG_WIDE void mark_crossings_wide(const ViewGeometry& geometry, const PixelRect& rect, const MarkedPixels& outlines,
                                     const TriangleNumbers& numbers, std::uint32_t last_other, MarkedPixels& to) {
    mark_crossings_body<Avx2Isa>(geometry, rect, outlines, numbers, last_other, to);
}

}  // namespace

void MarkedPixels::clear(int width, int y0, int y1) {
    y0_ = y0;
    y1_ = y1;
    words_ = (width + word_bits - 1) / word_bits;
    count_ = 0;
    bits_.assign(offset(y1), 0);
    first_.resize(bits_.size());
}

void MarkedPixels::take(const MarkedPixels& rows) {
    std::ranges::copy(rows.bits_, row(rows.y0_));
}

void MarkedPixels::number() {
    count_ = 0;
    for (std::size_t i = 0; i < bits_.size(); ++i) {
        first_[i] = count_;
        count_ += static_cast<std::uint32_t>(std::popcount(bits_[i]));
    }
}

void OutlineEdges::clear(const PixelRect& rect) {
    fill(numbers_.rows(), rect, none);
    fill(hidden_.rows(), rect, 0.0f);
}

void mark_outlines(const ViewGeometry& geometry, std::uint32_t first_triangle, std::uint32_t count,
                   const PixelRect& rect, Rows<float> depth, MarkedPixels& to, OutlineEdges* edges) {
    const EdgeMarks marks{geometry, rect, depth, to, edges};
    if (geometry.rays() != nullptr) {
        // Which edge it was is not kept: no pixel is taken for one that a single edge divides.
        if (geometry.wide_lanes()) return mark_ray_outlines_wide(marks, first_triangle, count);
        return mark_ray_outlines_body<PlainIsa>(marks, first_triangle, count);
    }
    for (std::uint32_t triangle = first_triangle; triangle < first_triangle + count; ++triangle) {
        const unsigned outline = geometry.triangles()[triangle].outline;
        if (outline == 0) continue;
        // The triangle itself may be so much nearer at the middle of a pixel than at its edge.
        const Setup setup = set_up(geometry, triangle);
        const float reach = depth_steps(setup, depth_plane(setup)).reach();
        for (std::uint32_t i = 0; i < 3; ++i)
            if ((outline >> i & 1) != 0) mark_edge(marks, edge_number(triangle, i), reach);
    }
}

void mark_crossings(const ViewGeometry& geometry, const PixelRect& rect, const MarkedPixels& outlines,
                    const TriangleNumbers& numbers, std::uint32_t last_other, MarkedPixels& to) {
    if (rect.width() <= 0 || rect.height() <= 0) return;
    if (geometry.wide_lanes()) return mark_crossings_wide(geometry, rect, outlines, numbers, last_other, to);
    mark_crossings_body<PlainIsa>(geometry, rect, outlines, numbers, last_other, to);
}

}  // namespace camrig::render::software
