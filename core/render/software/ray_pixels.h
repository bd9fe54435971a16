#pragma once

#include <array>
#include <cmath>

#include "core/render/software/ray_coverage.h"
#include "core/render/software/sample_places.h"

/// What a triangle covers inside of the pixels of a lens: within one pixel a ray changes evenly (what the strongest
/// lens bends there is below a thousandth of a pixel), and so do the weights of the corners and depth.
namespace camrig::render::software {

/// The ray of a pixel's centre, and its steps to the next pixel on the right and below.
struct PixelRay {
    glm::vec3 at, dx, dy;

    PixelRay(const LensRays& rays, int x, int y)
        : at(ray_at(rays, x, y)), dx(ray_at(rays, x + 1, y) - at), dy(ray_at(rays, x, y + 1) - at) {}

private:
    static glm::vec3 ray_at(const LensRays& rays, int x, int y) {
        const LensRays::Coordinates of = rays.rays();
        return {of.x(y)[x], of.y(y)[x], of.z(y)[x]};
    }
};

/// As along() of a group of rays, bit for bit.
CAMRIG_LANES float along(const glm::vec3& of, const glm::vec3& ray) {
    return ray.x * of.x + ray.y * of.y + ray.z * of.z;
}

/// Depth about the centre of a pixel.
CAMRIG_LANES PixelPlane depth_in_pixel(const RayTriangle& triangle, float farthest, const PixelRay& ray) {
    constexpr float step = 1.0f / 128.0f;
    return {along(triangle.depth, ray.at) + farthest, along(triangle.depth, ray.dx) * step,
            along(triangle.depth, ray.dy) * step};
}

/// The three edges of a triangle about the centre of a pixel.
class RayEdgesInPixel {
public:
    CAMRIG_LANES RayEdgesInPixel(const RayTriangle& triangle, const PixelRay& ray) : bias_(triangle.bias) {
        constexpr float step = 1.0f / 128.0f;
        for (std::size_t i = 0; i < 3; ++i) {
            value_[i] = along(triangle.edges[i], ray.at) + 0.0f;  // no -0: its bits are those of a negative number
            dx_[i] = along(triangle.edges[i], ray.dx) * step;
            dy_[i] = along(triangle.edges[i], ray.dy) * step;
            reach_[i] = most_offset * (std::abs(dx_[i]) + std::abs(dy_[i]));
        }
    }
    /// All of the pixel lies outside of one of them.
    CAMRIG_LANES bool is_outside() const {
        return value_[0] < -reach_[0] || value_[1] < -reach_[1] || value_[2] < -reach_[2];
    }
    /// The samples inside. For the triangle beyond an edge all of it is exactly the negative: none is left, none twice.
    template <typename Isa>
    CAMRIG_LANES SampleMask mask() const {
        std::array<IntLanes, sample_groups> outside{};
        bool is_crossed = false;
        for (std::size_t i = 0; i < 3; ++i) {
            if (value_[i] > reach_[i]) continue;
            is_crossed = true;
            for (int group = 0; group < sample_groups; ++group) {
                const Lanes at = value_[i] + (__builtin_convertvector(sample_x(group), Lanes) * dx_[i] +
                                              __builtin_convertvector(sample_y(group), Lanes) * dy_[i]);
                outside[static_cast<std::size_t>(group)] |= reinterpret_cast<IntLanes>(at + 0.0f) + bias_[i];
            }
        }
        if (!is_crossed) return all_samples;
        SampleMask made = 0;
        for (int group = 0; group < sample_groups; ++group)
            made |= SampleMask{Isa::bits(outside[static_cast<std::size_t>(group)])} << (lane_count * group);
        return ~made;
    }

private:
    std::array<float, 3> value_{}, dx_{}, dy_{}, reach_{};
    const std::array<std::int32_t, 3>& bias_;
};

/// The pixels that a triangle of a view through a lens may touch; pixels_of() has those whose centres it may cover.
CAMRIG_LANES PixelRect touched_by(const ScreenTriangle& triangle, const PixelRect& rect) {
    return {std::max<int>(rect.x0, triangle.x0 - 1), std::max<int>(rect.y0, triangle.y0 - 1),
            std::min<int>(rect.x1, triangle.x1 + 1), std::min<int>(rect.y1, triangle.y1 + 1)};
}

/// Calls visit(rect) for parts of the rectangle that hold all pixels which the triangle touches. outline: as of
/// may_touch().
template <typename Isa, typename Visit>
CAMRIG_LANES void each_touched_part(const LensRays& rays, const RayTriangle& triangle, float farthest, unsigned outline,
                                    const PixelRect& rect, const Visit& visit) {
    if (touches_few_tiles(rect)) return visit(rect);
    const auto may = [&](const RayBounds& bounds) __attribute__((always_inline)) {
        return may_touch<Isa>(triangle, farthest, rays.pixel_reach(), outline, bounds);
    };
    each_tile<Isa>(rays, rect, may, visit);
}

}  // namespace camrig::render::software
