#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/render/software/corner_values.h"

/// A triangle for each point of a group, all of one draw: pixels of a row, such that lie anywhere, or places of their
/// own. What is asked of them has the names of one_triangle.h.
namespace camrig::render::software {

/// Which draw each triangle is of; numbers from 1, where 0 gives any.
template <typename Isa>
CAMRIG_LANES IntLanes draws_of(const ScreenTriangle* triangles, IntLanes number) {
    static_assert(sizeof(ScreenTriangle) == 32);
    constexpr std::int32_t bits_of_draw = max_draws;
    const IntLanes index = number > 0 ? number - 1 : IntLanes{};
    return gathered<Isa>(reinterpret_cast<const std::int32_t*>(triangles) + 3, index * 8) & bits_of_draw;
}

/// A triangle for each pixel of a group, all of one draw.
template <typename Isa>
class TriangleOfEach {
public:
    using Value = Lanes;
    static constexpr bool stays_inside = false;

    /// numbers: of triangles, from 1; no lane is 0.
    CAMRIG_LANES TriangleOfEach(const ViewGeometry& geometry, const ViewDraw& draw, IntLanes numbers)
        : geometry_(geometry), draw_(draw) {
        static_assert(sizeof(ScreenTriangle) == 32 && sizeof(ScreenVertex) == 16);
        const ScreenTriangle* const triangles = geometry.triangles().data();
        const IntLanes index = index_ = numbers - 1;
        const bool is_on_screen = rays() == nullptr;
        if (is_on_screen) inverse_area_ = gathered<Isa>(&triangles->inverse_area, index * 4);
        Quads corners;
        Isa::quads(reinterpret_cast<const std::int32_t*>(triangles), index * 8, corners);
        front_ = corners[3] < 0;  // is_front is the highest bit
        for (std::size_t i = 0; i < 3; ++i) {
            if (is_on_screen) {
                Quads at;
                Isa::quads(reinterpret_cast<const std::int32_t*>(geometry.vertices().data()), corners[i] * 4, at);
                x_[i] = at[0];
                y_[i] = at[1];
                inverse_z_[i] = reinterpret_cast<Lanes>(at[3]);
            }
            vertex_[i] = corners[i] - static_cast<std::int32_t>(draw.first_vertex);
            const unsigned clipped = Isa::bits(vertex_[i] >= static_cast<std::int32_t>(draw.vertex_count));
            has_clipped_[i] = clipped != 0;
            all_clipped_[i] = clipped == 0xFF;
        }
    }

    CAMRIG_LANES const LensRays* rays() const { return geometry_.rays(); }
    CAMRIG_LANES PointRays point_rays(int x, int y) const { return point_rays_at(*rays(), x, y); }
    CAMRIG_LANES RayEdges<Lanes> ray_edges() const {
        static_assert(sizeof(RayTriangle) == 16 * sizeof(float));
        const RayTriangle* const triangles = geometry_.ray_triangles().data();
        const auto of = [&](const float& first)
                            __attribute__((always_inline)) { return gathered<Isa>(&first, index_ * 16); };
        RayEdges<Lanes> made;
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::vec3& edge = triangles->edges[i];
            made.edges[i] = {of(edge.x), of(edge.y), of(edge.z)};
        }
        made.length = of(triangles->length);
        return made;
    }
    /// As OneTriangle::shares: within guard_px (screen_triangles.h) these doubles are whole numbers too.
    CAMRIG_LANES ScreenShares<Lanes> shares(int x, int y) const {
        const Edge second = edge_from(2, 0), third = edge_from(0, 1);
        ScreenShares<Lanes> made = shares_of(second, third);
        made.second = narrowed(second.at(x, y) * inverse_area_) + lane_numbers() * made.second_dx;
        made.third = narrowed(third.at(x, y) * inverse_area_) + lane_numbers() * made.third_dx;
        return made;
    }
    CAMRIG_LANES Lanes inverse_z(std::size_t corner) const { return inverse_z_[corner]; }
    CAMRIG_LANES Lanes where_front(Lanes front, Lanes back) const { return front_ ? front : back; }

    template <std::size_t size>
    CAMRIG_LANES std::array<Lanes, size> values(std::size_t corner, const CornerAttribute& attribute) const {
        std::array<Lanes, size> made;
        const IntLanes vertex = vertex_[corner];
        if (has_clipped_[corner]) {
            // Two places, of which each lane takes one.
            const auto count = static_cast<std::int32_t>(draw_.vertex_count);
            const IntLanes is_clipped = vertex >= count;
            const IntLanes of_mesh = is_clipped ? IntLanes{} : vertex,
                           of_clipped = is_clipped ? vertex - count : IntLanes{};
            constexpr auto stride = static_cast<std::int32_t>(sizeof(VertexValues) / sizeof(float));
            const auto* const first = reinterpret_cast<const float*>(
                reinterpret_cast<const std::byte*>(geometry_.clipped().data() + draw_.first_clipped) +
                attribute.of_clipped);
            const bool is_all_clipped = all_clipped_[corner];
            for (std::size_t i = 0; i < size; ++i) {
                const Lanes clipped = gathered<Isa>(first + i, of_clipped * stride);
                if (is_all_clipped) {
                    made[i] = clipped;
                } else {
                    made[i] = is_clipped ? clipped : gathered<Isa>(attribute.of_mesh + i, of_mesh * attribute.stride);
                }
            }
        } else {
            load(attribute, vertex, made);
        }
        return made;
    }

protected:
    /// A vertex's values lie beside each other: by few whole loads, where gathers would take most of the time.
    template <std::size_t size>
    CAMRIG_LANES static void load(const CornerAttribute& attribute, IntLanes vertex, std::array<Lanes, size>& to) {
        static_assert(2 <= size && size <= 4);
        if constexpr (size == 2) {  // coordinates of textures, with nothing between them
            // Ordered so that no shuffle has to cross the halves of a vector.
            const IntLanes order = __builtin_shufflevector(vertex, vertex, 0, 1, 4, 5, 2, 3, 6, 7);
            const auto* const pairs = reinterpret_cast<const std::int64_t*>(attribute.of_mesh);
            Words4 low, high;
            Isa::template gather<0>(pairs, order, low);
            Isa::template gather<1>(pairs, order, high);
            const auto a = reinterpret_cast<Lanes>(low), b = reinterpret_cast<Lanes>(high);
            to[0] = __builtin_shufflevector(a, b, 0, 2, 8, 10, 4, 6, 12, 14);
            to[1] = __builtin_shufflevector(a, b, 1, 3, 9, 11, 5, 7, 13, 15);
        } else {
            // Four words where three are wanted begin one before them, but for the first vertex: none behind the last.
            const IntLanes before = size == 3 ? vertex > 0 : IntLanes{};
            const auto* const words = reinterpret_cast<const std::int32_t*>(attribute.of_mesh);
            Quads four;
            Isa::quads(words, vertex * attribute.stride + before, four);
            for (std::size_t i = 0; i < size; ++i)
                to[i] = reinterpret_cast<Lanes>(before ? four[std::min<std::size_t>(i + 1, 3)] : four[i]);
        }
    }

    struct Edge {
        Doubles dx, dy, from_x, from_y;

        CAMRIG_LANES Doubles at(int x, int y) const {
            return dx * (static_cast<double>(y * subpixels) - from_y) -
                   dy * (static_cast<double>(x * subpixels) - from_x);
        }
        CAMRIG_LANES Doubles at(const Doubles& x, const Doubles& y) const {
            return dx * (y - from_y) - dy * (x - from_x);
        }
    };
    CAMRIG_LANES Edge edge_from(std::size_t from, std::size_t to) const {
        return {widened(x_[to] - x_[from]), widened(y_[to] - y_[from]), widened(x_[from]), widened(y_[from])};
    }
    CAMRIG_LANES ScreenShares<Lanes> shares_of(const Edge& second, const Edge& third) const {
        const Doubles scale = inverse_area_ * static_cast<double>(subpixels);
        ScreenShares<Lanes> made;
        made.second_dx = narrowed(-second.dy * scale);
        made.third_dx = narrowed(-third.dy * scale);
        made.second_dy = narrowed(second.dx * scale);
        made.third_dy = narrowed(third.dx * scale);
        return made;
    }

    const ViewGeometry& geometry_;
    const ViewDraw& draw_;
    Doubles inverse_area_{};
    IntLanes index_, front_;
    std::array<IntLanes, 3> vertex_, x_{}, y_{};  ///< vertex: of the draw
    std::array<Lanes, 3> inverse_z_{};
    std::array<bool, 3> has_clipped_, all_clipped_;
};

/// Pixels that lie anywhere, by the groups that they are of.
struct PixelLanes {
    IntLanes first, lane, y;  ///< the first pixel of the group, which one of it, and the row

    /// A value that is there for each pixel.
    template <typename Isa>
    CAMRIG_LANES Lanes of(const Rows<const float>& plane, int right, int down) const {
        const auto stride = static_cast<std::int32_t>(plane.stride);
        return gathered<Isa>(plane.data, (y + down) * stride + (first + lane + right));
    }
    template <typename Isa>
    CAMRIG_LANES Lanes3 rays(const LensRays& rays, int right, int down) const {
        const LensRays::Coordinates at = rays.rays();
        return {of<Isa>(at.x, right, down), of<Isa>(at.y, right, down), of<Isa>(at.z, right, down)};
    }
};

/// A triangle of one draw for each of pixels that lie anywhere.
template <typename Isa>
class TriangleOfPixels : public TriangleOfEach<Isa> {
public:
    CAMRIG_LANES TriangleOfPixels(const ViewGeometry& geometry, const ViewDraw& draw, IntLanes numbers,
                                  const PixelLanes& pixels)
        : TriangleOfEach<Isa>(geometry, draw, numbers), pixels_(pixels) {}

    CAMRIG_LANES ScreenShares<Lanes> shares(int, int) const {
        const auto second = this->edge_from(2, 0), third = this->edge_from(0, 1);
        ScreenShares<Lanes> made = this->shares_of(second, third);
        const Doubles x = widened(pixels_.first * subpixels), y = widened(pixels_.y * subpixels);
        const Lanes lane = __builtin_convertvector(pixels_.lane, Lanes);
        made.second = narrowed(second.at(x, y) * this->inverse_area_) + lane * made.second_dx;
        made.third = narrowed(third.at(x, y) * this->inverse_area_) + lane * made.third_dx;
        return made;
    }

    CAMRIG_LANES PointRays point_rays(int, int) const {
        const LensRays& rays = *this->rays();
        const Lanes3 at = pixels_.template rays<Isa>(rays, 0, 0);
        return {at, pixels_.template rays<Isa>(rays, 1, 0) - at, pixels_.template rays<Isa>(rays, 0, 1) - at};
    }

private:
    PixelLanes pixels_;
};

/// Triangles of one draw at places of their own, in subpixels; share: how far it is to the next pixel there.
template <typename Isa>
class TriangleAtPlaces : public TriangleOfEach<Isa> {
public:
    /// Beyond a sliver its shares grow without bound within a pixel, so they are clamped.
    static constexpr bool stays_inside = true;

    CAMRIG_LANES TriangleAtPlaces(const ViewGeometry& geometry, const ViewDraw& draw, IntLanes numbers,
                                  const Doubles& x, const Doubles& y, Lanes share)
        : TriangleOfEach<Isa>(geometry, draw, numbers), x_at_(x), y_at_(y), share_(share) {}

    CAMRIG_LANES ScreenShares<Lanes> shares(int, int) const {
        const auto second = this->edge_from(2, 0), third = this->edge_from(0, 1);
        ScreenShares<Lanes> made = this->shares_of(second, third);
        made.second = clamp01(narrowed(second.at(x_at_, y_at_) * this->inverse_area_));
        made.third = min(clamp01(narrowed(third.at(x_at_, y_at_) * this->inverse_area_)), 1.0f - made.second);
        for (Lanes* step : {&made.second_dx, &made.third_dx, &made.second_dy, &made.third_dy}) *step = *step * share_;
        return made;
    }

    /// Between the rays of pixels.
    CAMRIG_LANES PointRays point_rays(int, int) const {
        const Doubles x = x_at_ * (1.0 / subpixels), y = y_at_ * (1.0 / subpixels);
        const IntLanes column = rounded(x), row = rounded(y);
        const Lanes right = narrowed(x - widened(column)), down = narrowed(y - widened(row));
        const LensRays::Coordinates of = this->rays()->rays();
        const auto along = [&](const Rows<const float>& plane, Lanes& at, Lanes& dx, Lanes& dy)
                               __attribute__((always_inline)) {
                                   const auto stride = static_cast<std::int32_t>(plane.stride);
                                   const IntLanes first = row * stride + column;
                                   const Lanes centre = gathered<Isa>(plane.data, first);
                                   dx = gathered<Isa>(plane.data, first + 1) - centre;
                                   dy = gathered<Isa>(plane.data, first + stride) - centre;
                                   at = centre + dx * right + dy * down;
                                   dx = dx * share_;
                                   dy = dy * share_;
                               };
        PointRays made;
        along(of.x, made.at.x, made.dx.x, made.dy.x);
        along(of.y, made.at.y, made.dx.y, made.dy.y);
        along(of.z, made.at.z, made.dx.z, made.dy.z);
        return made;
    }

private:
    Doubles x_at_, y_at_;
    Lanes share_;
};

}  // namespace camrig::render::software
