#pragma once

#include <array>
#include <cstddef>

#include "core/render/software/corner_values.h"

/// One triangle for a group of points: pixels of a row, or places within one pixel. What is asked of it has the names
/// that the triangles of triangle_of_each.h have, and the same operations in the same order give it: a pixel has the
/// same bits whatever is beside it.
namespace camrig::render::software {

/// One triangle for all pixels of a group.
class OneTriangle {
public:
    using Value = float;
    static constexpr bool stays_inside = false;  ///< whether a point beside a triangle takes what its border has

    CAMRIG_LANES OneTriangle(const ViewGeometry& geometry, const ViewDraw& draw, const ScreenTriangle& triangle,
                             const Setup& setup)
        : rays_(geometry.rays()), setup_(setup), is_front_(triangle.is_front) {
        for (std::size_t i = 0; i < 3; ++i) corners_[i] = corner_of(geometry, draw, triangle.vertices[i]);
    }

    CAMRIG_LANES const LensRays* rays() const { return rays_; }
    CAMRIG_LANES PointRays point_rays(int x, int y) const { return point_rays_at(*rays_, x, y); }
    CAMRIG_LANES RayEdges<float> ray_edges() const {
        RayEdges<float> made;
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::vec3& edge = setup_.ray->edges[i];
            made.edges[i] = {edge.x, edge.y, edge.z};
        }
        made.length = setup_.ray->length;
        return made;
    }
    /// x is the first pixel of the group.
    CAMRIG_LANES ScreenShares<float> shares(int x, int y) const {
        const Setup& s = setup_;
        const std::int64_t px = std::int64_t{x} * subpixels, py = std::int64_t{y} * subpixels;
        const double scale = s.inverse_area * subpixels;
        ScreenShares<float> made;
        made.second_dx = static_cast<float>(-s.dy[1] * scale);
        made.third_dx = static_cast<float>(-s.dy[2] * scale);
        made.second_dy = static_cast<float>(s.dx[1] * scale);
        made.third_dy = static_cast<float>(s.dx[2] * scale);
        made.second = static_cast<float>(static_cast<double>(edge(s, 1, px, py)) * s.inverse_area) +
                      lane_numbers() * made.second_dx;
        made.third = static_cast<float>(static_cast<double>(edge(s, 2, px, py)) * s.inverse_area) +
                     lane_numbers() * made.third_dx;
        return made;
    }
    CAMRIG_LANES float inverse_z(std::size_t corner) const { return setup_.at[corner]->inverse_z; }
    CAMRIG_LANES Lanes where_front(Lanes front, Lanes back) const { return is_front_ ? front : back; }

    template <std::size_t size>
    CAMRIG_LANES std::array<float, size> values(std::size_t corner, const CornerAttribute& attribute) const {
        const float* const from = values_at(corners_[corner], attribute);
        std::array<float, size> made;
        for (std::size_t i = 0; i < size; ++i) made[i] = from[i];
        return made;
    }

private:
    const LensRays* rays_;
    const Setup& setup_;
    std::array<Corner, 3> corners_;
    bool is_front_;
};

/// One triangle at places within one pixel; a step is `share` of a pixel's side.
class TriangleInPixel : public OneTriangle {
public:
    /// Beyond a sliver its shares grow without bound within a pixel, so they are clamped.
    static constexpr bool stays_inside = true;

    CAMRIG_LANES TriangleInPixel(const ViewGeometry& geometry, const ViewDraw& draw, const ScreenTriangle& triangle,
                                 const Setup& setup, int x, int y, float share)
        : OneTriangle(geometry, draw, triangle, setup), share_(share) {
        if (rays() != nullptr) {
            middle_ray_ = OneTriangle::point_rays(x, y);
        } else {
            middle_ = OneTriangle::shares(x, y);
        }
    }
    /// From the middle of the pixel, in pixels.
    CAMRIG_LANES void go_to(Lanes right, Lanes down) {
        right_ = right;
        down_ = down;
    }

    CAMRIG_LANES ScreenShares<float> shares(int, int) const {
        ScreenShares<float> made = middle_;
        made.second = clamp01(middle_.second[0] + right_ * middle_.second_dx + down_ * middle_.second_dy);
        made.third = middle_.third[0] + right_ * middle_.third_dx + down_ * middle_.third_dy;
        made.third = min(clamp01(made.third), 1.0f - made.second);
        for (float* step : {&made.second_dx, &made.third_dx, &made.second_dy, &made.third_dy}) *step *= share_;
        return made;
    }
    /// Between the rays of pixels.
    CAMRIG_LANES PointRays point_rays(int, int) const {
        const auto& [at, dx, dy] = middle_ray_;
        const auto step = [&](const Lanes3& of) __attribute__((always_inline)) {
            return Lanes3{lanes(of.x[0]), lanes(of.y[0]), lanes(of.z[0])};
        };
        const Lanes3 right = step(dx), down = step(dy);
        return {step(at) + right * right_ + down * down_, right * lanes(share_), down * lanes(share_)};
    }

private:
    ScreenShares<float> middle_{};
    PointRays middle_ray_{};
    Lanes right_{}, down_{};
    float share_;
};

}  // namespace camrig::render::software
