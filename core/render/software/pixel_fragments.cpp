#include "core/render/software/pixel_fragments.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "core/render/software/coverage.h"
#include "core/render/software/ray_pixels.h"
#include "core/render/software/sample_places.h"
#include "core/render/software/shading.h"
#include "core/render/software/surface_point.h"

namespace camrig::render::software {
namespace {

/// The edges of a triangle at the places of pixels; not negative is inside.
class EdgesInPixels {
public:
    CAMRIG_LANES explicit EdgesInPixels(const Setup& setup)
        : setup_(setup), depth_(depth_plane(setup)), steps_(depth_steps(setup, depth_)), depth_reach_(steps_.reach()) {
        for (std::size_t i = 0; i < 3; ++i) {
            const bool is_top_left = setup.dy[i] < 0 || (setup.dy[i] == 0 && setup.dx[i] > 0);
            bias_[i] = is_top_left ? 0 : -1;
            reach_[i] = std::int64_t{offset_in_subpixels * most_offset} *
                        (std::abs(std::int64_t{setup.dx[i]}) + std::abs(std::int64_t{setup.dy[i]}));
        }
    }

    /// Of edge i, with the rule of who owns it.
    CAMRIG_LANES std::int64_t at(std::size_t i, int x, int y) const {
        return edge(setup_, i, std::int64_t{x} * subpixels, std::int64_t{y} * subpixels) + bias_[i];
    }
    CAMRIG_LANES std::int64_t reach(std::size_t i) const { return reach_[i]; }
    CAMRIG_LANES float depth_reach() const { return depth_reach_; }

    CAMRIG_LANES PixelPlane plane(const std::array<std::int64_t, 3>& values) const {
        const double z = depth_.base + static_cast<double>(values[1] - bias_[1]) * depth_.second +
                         static_cast<double>(values[2] - bias_[2]) * depth_.third;
        return {static_cast<float>(z), steps_.dx, steps_.dy};
    }

    /// values: of the three edges; none is beyond its reach.
    template <typename Isa>
    CAMRIG_LANES SampleMask mask(const std::array<std::int64_t, 3>& values) {
        std::array<IntLanes, sample_groups> outside{};
        bool is_crossed = false;
        for (std::size_t i = 0; i < 3; ++i) {
            if (values[i] >= reach_[i]) continue;
            is_crossed = true;
            if (!has_places_[i]) find_places(i);
            const auto middle = static_cast<std::int32_t>(values[i] >> 1);
            for (std::size_t group = 0; group < sample_groups; ++group) outside[group] |= places_[i][group] + middle;
        }
        if (!is_crossed) return all_samples;
        SampleMask made = 0;
        for (std::size_t group = 0; group < sample_groups; ++group)
            made |= SampleMask{Isa::bits(outside[group])} << (lane_count * group);
        return ~made;
    }

private:
    CAMRIG_LANES void find_places(std::size_t i) {
        has_places_[i] = true;
        // half_edge_at(), whose second product grows evenly.
        IntLanes across = sample_x(0) * setup_.dy[i];
        for (int group = 0; group < sample_groups; ++group) {
            places_[i][static_cast<std::size_t>(group)] = sample_y(group) * setup_.dx[i] - across;
            across += 2 * lane_count * setup_.dy[i];
        }
    }

    const Setup& setup_;
    DepthPlane depth_;
    PixelPlane steps_;
    float depth_reach_;
    std::array<std::int64_t, 3> bias_{}, reach_{};
    std::array<bool, 3> has_places_{};
    std::array<std::array<IntLanes, sample_groups>, 3> places_;
};

/// The places at which a masked surface is there.
template <typename Isa>
CAMRIG_LANES SampleMask with_alpha(const ViewGeometry& geometry, const ScreenTriangle& triangle, const Setup& setup,
                                   int x, int y, SampleMask mask) {
    constexpr float between = 1.0f / 8.0f;  // of a pixel's side, from a place to the next
    constexpr float pixel = float{offset_in_subpixels} / subpixels;
    const ViewDraw& draw = geometry.draws()[triangle.draw];
    TriangleInPixel at(geometry, draw, triangle, setup, x, y, between);
    SampleMask made = 0;
    for (int group = 0; group < sample_groups; ++group) {
        const SampleMask bits = mask >> (lane_count * group) & 0xFF;
        if (bits == 0) continue;
        at.go_to(__builtin_convertvector(sample_x(group), Lanes) * pixel,
                 __builtin_convertvector(sample_y(group), Lanes) * pixel);
        const Lanes alpha = base_alpha<Isa>(draw, points_of<PointValues::of_alpha>(geometry, draw, at, x, y));
        made |= (bits & Isa::bits(alpha >= draw.primitive->material->alpha_cutoff)) << (lane_count * group);
    }
    return made;
}

/// Pixels of a row that a triangle may touch.
struct Span {
    int x0, x1;
};

CAMRIG_LANES Span span_of(const EdgesInPixels& edges, const Setup& s, const PixelRect& box, int y) {
    Span span{box.x0, box.x1};
    for (std::size_t i = 0; i < 3; ++i) {
        const double least = -static_cast<double>(edges.reach(i)) - static_cast<double>(edges.at(i, box.x0, y));
        const double step = -static_cast<double>(s.dy[i]) * subpixels;
        if (step == 0.0) {
            if (least > 0.0) return {0, 0};
            continue;
        }
        // One pixel more, for rounding.
        const double steps = std::clamp(least / step, -2.0, box.width() + 2.0);
        if (step > 0.0) {
            span.x0 = std::max(span.x0, box.x0 + static_cast<int>(steps) - 1);
        } else {
            span.x1 = std::min(span.x1, box.x0 + static_cast<int>(steps) + 2);
        }
    }
    return span;
}

CAMRIG_LANES bool is_masked(const ViewDraw& draw) {
    return draw.primitive->material->alpha_mode == world::AlphaMode::mask;
}

/// Of a triangle seen through a lens.
template <typename Isa>
CAMRIG_LANES void find_ray_fragments(const ViewGeometry& geometry, std::uint32_t number, const PixelRect& rect,
                                     const MarkedPixels& marked, PixelFragments& to) {
    const ScreenTriangle& triangle = geometry.triangles()[number];
    const PixelRect box = touched_by(triangle, rect);
    if (box.width() <= 0 || box.height() <= 0) return;
    const RayTriangle& rays = geometry.ray_triangles()[number];
    const float farthest = geometry.farthest();
    const auto visit = [&](int x, int y) __attribute__((always_inline)) {
        const std::uint32_t pixel = marked.index_of(x, y);
        const PixelRay ray(*geometry.rays(), x, y);
        const PixelPlane plane = depth_in_pixel(rays, farthest, ray);
        const float reach = plane.reach(), nearest = plane.z + reach;
        // Before the near plane nothing shows.
        if (!(nearest > 0.0f) || plane.z > 1.0f || !to.may_show(pixel, nearest)) return;
        const RayEdgesInPixel edges(rays, ray);
        if (edges.is_outside()) return;
        SampleMask mask = edges.template mask<Isa>() & to.open_places(pixel, nearest);
        if (mask == 0) return;
        if (is_masked(geometry.draws()[triangle.draw]))
            mask = with_alpha<Isa>(geometry, triangle, set_up(geometry, number), x, y, mask);
        if (mask != 0) to.add(pixel, mask, plane, reach, number);
    };
    each_touched_part<Isa>(*geometry.rays(), rays, farthest, 0, box,
                           [&](const PixelRect& part) __attribute__((always_inline)) {
                               for (int y = part.y0; y < part.y1; ++y) marked.each_between(y, part.x0, part.x1, visit);
                           });
}

template <typename Isa>
CAMRIG_LANES void find_fragments_body(const ViewGeometry& geometry, std::uint32_t first, std::uint32_t count,
                                      const PixelRect& rect, const MarkedPixels& marked, PixelFragments& to) {
    constexpr int half = subpixels / 2, narrow = 8;
    if (geometry.rays() != nullptr) {
        for (std::uint32_t number = first; number < first + count; ++number)
            find_ray_fragments<Isa>(geometry, number, rect, marked, to);
        return;
    }
    const ScreenVertex* const vertices = geometry.vertices().data();
    // Leaf behind leaf: which places a mask leaves open is dear to ask. Those with masks come last and the nearest
    // first: only such places are asked for that nothing nearer has taken.
    std::vector<PixelFragments::Later>& later = to.later;
    later.clear();
    for (std::size_t n = 0; n < count + later.size(); ++n) {
        if (n == count) std::ranges::sort(later);
        const std::uint32_t number = n < count ? first + static_cast<std::uint32_t>(n) : later[n - count].triangle;
        const ScreenTriangle& triangle = geometry.triangles()[number];
        const ScreenVertex &a = vertices[triangle.vertices[0]], &b = vertices[triangle.vertices[1]],
                           &c = vertices[triangle.vertices[2]];
        const PixelRect box{std::max(rect.x0, (std::min({a.x, b.x, c.x}) + half) >> 8),
                            std::max(rect.y0, (std::min({a.y, b.y, c.y}) + half) >> 8),
                            std::min(rect.x1, ((std::max({a.x, b.x, c.x}) + half) >> 8) + 1),
                            std::min(rect.y1, ((std::max({a.y, b.y, c.y}) + half) >> 8) + 1)};
        if (box.width() <= 0 || box.height() <= 0) continue;
        const float nearest = std::max({a.depth, b.depth, c.depth});
        const bool has_mask = is_masked(geometry.draws()[triangle.draw]);
        if (has_mask && n < count) {
            later.push_back({-nearest, number});
            continue;
        }
        Setup setup;
        std::optional<EdgesInPixels> edges;
        const auto visit = [&](int x, int y) __attribute__((always_inline)) {
            const std::uint32_t pixel = marked.index_of(x, y);
            if (!to.may_show(pixel, nearest)) return;
            if (!edges) {
                setup = set_up(vertices, triangle);
                edges.emplace(setup);
            }
            std::array<std::int64_t, 3> values{};
            for (std::size_t i = 0; i < 3; ++i) {
                values[i] = edges->at(i, x, y);
                if (values[i] < -edges->reach(i)) return;
            }
            const PixelPlane plane = edges->plane(values);
            const float z = plane.z + edges->depth_reach();
            if (!(z > 0.0f) || !to.may_show(pixel, z)) return;
            SampleMask mask = edges->mask<Isa>(values) & to.open_places(pixel, z);
            if (mask == 0) return;
            if (has_mask) {
                mask = with_alpha<Isa>(geometry, triangle, setup, x, y, mask);
                if (mask == 0) return;
            }
            to.add(pixel, mask, plane, edges->depth_reach(), number);
        };
        for (int y = box.y0; y < box.y1; ++y) {
            Span span{box.x0, box.x1};
            if (box.width() > narrow) {
                if (!edges) {
                    setup = set_up(vertices, triangle);
                    edges.emplace(setup);
                }
                span = span_of(*edges, setup, box, y);
            }
            marked.each_between(y, span.x0, span.x1, visit);
        }
    }
}

CAMRIG_WIDE void find_fragments_wide(const ViewGeometry& geometry, std::uint32_t first, std::uint32_t count,
                                     const PixelRect& rect, const MarkedPixels& marked, PixelFragments& to) {
    find_fragments_body<Avx2Isa>(geometry, first, count, rect, marked, to);
}

}  // namespace

void find_fragments(const ViewGeometry& geometry, std::uint32_t first_triangle, std::uint32_t count,
                    const PixelRect& rect, const MarkedPixels& marked, PixelFragments& to) {
    if (rect.width() <= 0 || rect.height() <= 0 || marked.count() == 0) return;
    if (geometry.wide_lanes()) return find_fragments_wide(geometry, first_triangle, count, rect, marked, to);
    find_fragments_body<PlainIsa>(geometry, first_triangle, count, rect, marked, to);
}

}  // namespace camrig::render::software
