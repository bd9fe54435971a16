#include "core/render/software/ray_triangles.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "core/render/software/lens_formula.h"
#include "core/render/software/local_points.h"
#include "core/render/software/ray_coverage.h"

namespace camrig::render::software {
namespace {

/// Vertices that are further away are nowhere.
constexpr double farthest_m = 1e30;
/// The end of the lens, and what rounding makes of it.
constexpr float rounded_end = 1.000001f;
/// Of a box around a bent edge's ends, beside what it is bent: for rounding.
constexpr std::int32_t rounding_subpixels = 2;

template <typename Isa>
CAMRIG_LANES void place_body(const LensNumbers& lens, ImageSize size, const glm::dmat4& m, const glm::vec3* positions,
                             std::span<const std::uint32_t> which, LensVertex* to) {
    // A short edge between two vertices beside the picture may be bent into it.
    constexpr double margin = scene::LensView::most_bend_px + double{rounding_subpixels} / subpixels;
    const double left = -0.5 - margin, right = size.width - 0.5 + margin, bottom = size.height - 0.5 + margin;
    for (std::size_t i = 0; i < which.size(); i += lane_count) {
        const IntLanes at = indices_at(which.data() + i, which.size() - i);
        const auto [x, y, z] = transformed<Isa>(m, positions, at);
        const Doubles far = Doubles{} + farthest_m;
        const Doubles w = lens.is_wide ? sqrt(x * x + y * y + z * z) : z;
        const Doubles reach = lens.is_wide ? far : z * lens.guard;
        // Not of a number: never inside.
        const IntLanes in_guard = (magnitude(x) <= reach) & (magnitude(y) <= reach) & (w <= far);
        const IntLanes is_near = w < Doubles{} + lens.near_m;
        const IntLanes is_placed = in_guard & ~is_near;
        const Doubles one = Doubles{} + 1.0, inverse = 1.0 / select(is_placed, w, one);
        const Doubles u = select(is_placed, x, Doubles{}) * inverse, v = select(is_placed, y, Doubles{}) * inverse;
        const Doubles ahead = lens.is_wide ? select(is_placed, z, one) * inverse : one;
        const ThroughLens seen_at = through_lens(lens, narrowed(u), narrowed(v), narrowed(ahead));
        const Doubles factor = widened(seen_at.factor);
        const Doubles px = (u * factor + widened(seen_at.aside_x)) * lens.k.fx + lens.k.cx;
        const Doubles py = (v * factor + widened(seen_at.aside_y)) * lens.k.fy + lens.k.cy;
        // Beyond the end of the lens a place says nothing about what lies between it and others.
        const IntLanes is_shown = seen_at.radius <= lens.end * rounded_end;
        const IntLanes beside = ((px < Doubles{} + left) & outside_left) | ((Doubles{} + right < px) & outside_right) |
                                ((py < Doubles{} + left) & outside_top) | ((Doubles{} + bottom < py) & outside_bottom);
        const IntLanes beyond =
            is_shown ? beside : (IntLanes{} + outside_end) | ((seen_at.radius > lens.seen) & outside_lens);
        const IntLanes bits = is_placed ? beyond : (is_near & outside_near) | (~in_guard & outside_guard);
        const IntLanes sx = rounded(px * static_cast<double>(subpixels));
        const IntLanes sy = rounded(py * static_cast<double>(subpixels));
        const Lanes fx = narrowed(x), fy = narrowed(y), fz = narrowed(z);
        for (int k = 0; k < lane_count; ++k)
            to[at[k]] = {.at = {fx[k], fy[k], fz[k]},
                         .x = sx[k],
                         .y = sy[k],
                         .ideal = {seen_at.ideal_x[k], seen_at.ideal_y[k]},
                         .outside = bits[k]};
    }
}

CAMRIG_WIDE void place_wide(const LensNumbers& lens, ImageSize size, const glm::dmat4& optical_from_local,
                            const glm::vec3* positions, std::span<const std::uint32_t> which, LensVertex* to) {
    place_body<Avx2Isa>(lens, size, optical_from_local, positions, which, to);
}

/// Corners that run clockwise as they are seen. Rounding keeps the edges of neighbours each other's negatives: they are
/// scaled by powers of two.
RayTriangle ray_triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double depth_shift) {
    constexpr std::uint64_t exponent_bits = 0x7FF0'0000'0000'0000;
    const std::array<glm::dvec3, 3> edges{glm::cross(b, c), glm::cross(c, a), glm::cross(a, b)};
    const double volume = glm::dot(a, edges[0]);
    double largest = 0.0;
    for (const glm::dvec3& edge : edges)
        largest = std::max({largest, std::abs(edge.x), std::abs(edge.y), std::abs(edge.z)});
    const double scale = 1.0 / std::bit_cast<double>(std::bit_cast<std::uint64_t>(largest) & exponent_bits);
    RayTriangle made;
    for (std::size_t i = 0; i < 3; ++i) {
        made.edges[i] = glm::vec3(edges[i] * scale);
        const glm::vec3& edge = made.edges[i];
        const float first = edge.x != 0.0f ? edge.x : edge.y != 0.0f ? edge.y : edge.z;
        made.bias[i] = first > 0.0f ? 0 : -1;
    }
    made.length = static_cast<float>(volume * scale);
    made.depth = glm::vec3((edges[0] + edges[1] + edges[2]) * (depth_shift / volume));
    return made;
}

/// The pixels of the blocks in which it may show; thin: in which it may touch a pixel.
template <typename Isa>
CAMRIG_LANES PixelRect hull_of_blocks(const RayTriangle& triangle, float farthest, const LensRays& rays, bool thin) {
    constexpr int block = LensRays::block_side;
    const PixelRect whole = rays.whole();
    PixelRect hull{whole.x1, whole.y1, 0, 0};
    for (int row = 0; row * block < whole.y1; ++row) {
        for (int first = 0; first * block < whole.x1; first += lane_count) {
            const RayBounds bounds = bounds_at(rays.blocks(), first, row);
            const unsigned blocks = thin ? may_touch<Isa>(triangle, farthest, rays.pixel_reach(), 0, bounds)
                                         : may_show<Isa>(triangle, farthest, bounds);
            if (blocks == 0) continue;
            hull.x0 = std::min(hull.x0, (first + std::countr_zero(blocks)) * block);
            hull.x1 = std::max(hull.x1, (first + static_cast<int>(std::bit_width(blocks))) * block);
            hull.y0 = std::min(hull.y0, row * block);
            hull.y1 = (row + 1) * block;
        }
    }
    return common(hull, whole);
}

/// The longest edge of each triangle on the ideal plane, squared.
template <typename Isa>
CAMRIG_LANES Lanes longest_edge2(const LensVertex* vertices, const std::array<IntLanes, 3>& corner) {
    constexpr auto words = static_cast<std::int32_t>(sizeof(LensVertex) / sizeof(float));
    std::array<Lanes, 3> x, y;
    for (std::size_t c = 0; c < 3; ++c) {
        x[c] = gathered<Isa>(&vertices->ideal.x, corner[c] * words);
        y[c] = gathered<Isa>(&vertices->ideal.y, corner[c] * words);
    }
    Lanes longest{};
    for (std::size_t c = 0; c < 3; ++c) {
        const Lanes dx = x[(c + 1) % 3] - x[c], dy = y[(c + 1) % 3] - y[c];
        longest = max(longest, dx * dx + dy * dy);
    }
    return longest;
}

/// Six times the volume between the eye and each triangle; positive where its corners are seen to run clockwise.
template <typename Isa>
CAMRIG_LANES Doubles volume_of(const LensVertex* vertices, const std::array<IntLanes, 3>& corner) {
    constexpr auto words = static_cast<std::int32_t>(sizeof(LensVertex) / sizeof(float));
    struct {
        Doubles x, y, z;
    } p[3];
    for (std::size_t c = 0; c < 3; ++c) {
        p[c].x = widened(gathered<Isa>(&vertices->at.x, corner[c] * words));
        p[c].y = widened(gathered<Isa>(&vertices->at.y, corner[c] * words));
        p[c].z = widened(gathered<Isa>(&vertices->at.z, corner[c] * words));
    }
    return p[0].x * (p[1].y * p[2].z - p[2].y * p[1].z) + p[0].y * (p[1].z * p[2].x - p[2].z * p[1].x) +
           p[0].z * (p[1].x * p[2].y - p[2].x * p[1].y);
}

template <typename Isa>
CAMRIG_LANES void assemble_rays_body(const scene::TriangleCorners& corners, const LensVertex* vertices,
                                     const TriangleRule& rule, const LensNumbers& lens, const LensRays& rays,
                                     OutlineScratch& scratch, std::vector<ScreenTriangle>& to,
                                     std::vector<RayTriangle>& rays_to) {
    static_assert(sizeof(LensVertex) == 8 * sizeof(float));
    constexpr std::int32_t words = 8, bits = 8;
    constexpr std::int32_t beside = outside_left | outside_right | outside_top | outside_bottom;
    constexpr double most_volume = 1e200;  // products of what is nowhere
    const auto farthest = static_cast<float>(lens.depth_scale);
    const std::size_t count = corners[0].size(), first = to.size();
    scratch.facing.assign(rule.neighbors != nullptr ? count : 0, facing_unknown);
    scratch.sources.clear();
    for (std::size_t i = 0; i < count; i += lane_count) {
        std::array<IntLanes, 3> corner, x, y, beyond;
        for (std::size_t c = 0; c < 3; ++c) {
            corner[c] = indices_at(corners[c].data() + i, count - i);
            beyond[c] = gathered<Isa>(&vertices->outside, corner[c] * words);
        }
        const IntLanes is_there =
            int_lane_numbers() < static_cast<std::int32_t>(std::min<std::size_t>(count - i, lane_count));
        const IntLanes any = beyond[0] | beyond[1] | beyond[2], all = beyond[0] & beyond[1] & beyond[2];
        const Lanes longest2 = longest_edge2<Isa>(vertices, corner);
        const IntLanes is_short = (longest2 <= lens.short_length2) & ((any & (outside_near | outside_guard)) == 0);
        const IntLanes is_beside = ((all & outside_near) != 0) | (is_short & ((all & (beside | outside_lens)) != 0));
        const IntLanes may_be_seen = is_there & ~is_beside;
        if (Isa::bits(may_be_seen) == 0) continue;
        const Doubles volume = volume_of<Isa>(vertices, corner);
        const IntLanes is_turned = volume < Doubles{};
        const IntLanes has_volume = (is_turned | (Doubles{} < volume)) & (magnitude(volume) < Doubles{} + most_volume);
        // Rows run down, so what is counter-clockwise in the world has a negative volume.
        const IntLanes is_front = rule.turns_clockwise ? ~is_turned : is_turned;
        const IntLanes is_seen = rule.is_double_sided ? IntLanes{} - 1 : is_front;
        // Between ends that the lens shows a short edge is bent by no more than this: its box is known.
        const IntLanes has_box = is_short & ((any & outside_end) == 0);
        for (std::size_t c = 0; c < 3; ++c) {
            x[c] = gathered<Isa>(&vertices->x, corner[c] * words);
            y[c] = gathered<Isa>(&vertices->y, corner[c] * words);
        }
        const IntLanes slack =
            truncated(min(longest2, lanes(lens.short_length2)) * lens.bend_subpixels) + rounding_subpixels;
        const IntLanes x0 = (min(x[0], min(x[1], x[2])) - slack + (subpixels - 1)) >> bits;
        const IntLanes y0 = (min(y[0], min(y[1], y[2])) - slack + (subpixels - 1)) >> bits;
        const IntLanes x1 = ((max(x[0], max(x[1], x[2])) + slack) >> bits) + 1;
        const IntLanes y1 = ((max(y[0], max(y[1], y[2])) + slack) >> bits) + 1;
        const IntLanes has_middles = rule.keeps_thin ? IntLanes{} - 1 : (x0 < x1) & (y0 < y1);
        const IntLanes is_kept = may_be_seen & is_seen & has_volume & (~has_box | has_middles);
        if (rule.neighbors != nullptr) {
            const IntLanes facing =
                has_volume & (is_turned ? IntLanes{} + facing_turned : IntLanes{} + facing_straight);
            for (std::size_t k = 0; k < std::min<std::size_t>(count - i, lane_count); ++k)
                scratch.facing[i + k] = static_cast<std::uint8_t>(facing[static_cast<int>(k)]);
        }
        for (unsigned left = Isa::bits(is_kept); left != 0; left &= left - 1) {
            const int k = std::countr_zero(left);
            std::array<std::uint32_t, 3> own{};
            for (std::size_t c = 0; c < 3; ++c) own[c] = static_cast<std::uint32_t>(corner[c][k]);
            if (is_turned[k] != 0) std::swap(own[1], own[2]);
            const RayTriangle made = ray_triangle(glm::dvec3(vertices[own[0]].at), glm::dvec3(vertices[own[1]].at),
                                                  glm::dvec3(vertices[own[2]].at), lens.depth_shift);
            const PixelRect box = has_box[k] != 0 ? common({x0[k], y0[k], x1[k], y1[k]}, rays.whole())
                                                  : hull_of_blocks<Isa>(made, farthest, rays, rule.keeps_thin);
            const int thin = rule.keeps_thin ? 1 : 0;  // may lie between the centres of two pixels
            if (box.width() + thin <= 0 || box.height() + thin <= 0) continue;
            if (rule.neighbors != nullptr)
                scratch.sources.push_back(static_cast<std::uint32_t>(i) + static_cast<std::uint32_t>(k));
            rays_to.push_back(made);
            to.push_back(
                {.vertices = {rule.first_vertex + own[0], rule.first_vertex + own[1], rule.first_vertex + own[2]},
                 .draw = rule.draw & max_draws,
                 .outline = rule.keeps_thin ? 7u : 0u,
                 .is_front = is_front[k] != 0,
                 .x0 = static_cast<std::int16_t>(box.x0),
                 .y0 = static_cast<std::int16_t>(box.y0),
                 .x1 = static_cast<std::int16_t>(box.x1),
                 .y1 = static_cast<std::int16_t>(box.y1)});
        }
    }
    if (rule.neighbors != nullptr) find_outline(*rule.neighbors, scratch, std::span(to).subspan(first));
}

CAMRIG_WIDE void assemble_rays_wide(const scene::TriangleCorners& corners, const LensVertex* vertices,
                                    const TriangleRule& rule, const LensNumbers& lens, const LensRays& rays,
                                    OutlineScratch& scratch, std::vector<ScreenTriangle>& to,
                                    std::vector<RayTriangle>& rays_to) {
    assemble_rays_body<Avx2Isa>(corners, vertices, rule, lens, rays, scratch, to, rays_to);
}

}  // namespace

void place_vertices(const LensNumbers& lens, ImageSize size, const glm::dmat4& optical_from_local,
                    const glm::vec3* positions, std::span<const std::uint32_t> which, bool wide, LensVertex* to) {
    if (wide) return place_wide(lens, size, optical_from_local, positions, which, to);
    place_body<PlainIsa>(lens, size, optical_from_local, positions, which, to);
}

void assemble_rays(const scene::TriangleCorners& corners, const LensVertex* vertices, const TriangleRule& rule,
                   const LensNumbers& lens, const LensRays& rays, bool wide, OutlineScratch& scratch,
                   std::vector<ScreenTriangle>& to, std::vector<RayTriangle>& rays_to) {
    if (wide) return assemble_rays_wide(corners, vertices, rule, lens, rays, scratch, to, rays_to);
    assemble_rays_body<PlainIsa>(corners, vertices, rule, lens, rays, scratch, to, rays_to);
}

}  // namespace camrig::render::software
