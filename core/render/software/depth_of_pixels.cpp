#include "core/render/software/depth_of_pixels.h"

#include <algorithm>
#include <cmath>

#include "core/render/software/lens_rays.h"
#include "core/render/software/surface_point.h"

namespace camrig::render::software {
namespace {

/// Of a point or a line, which has no plane in space but one on the screen.
DepthOfPixels depth_of_stroke(const ViewGeometry& geometry, const ScreenTriangle& triangle) {
    const Setup s = set_up(geometry.vertices().data(), triangle);
    const auto inverse_z = [&](std::size_t i) { return static_cast<double>(s.at[i]->inverse_z); };
    DepthOfPixels made{.ahead = inverse_z(0), .offset = 1.0};
    for (const std::size_t i : {std::size_t{1}, std::size_t{2}}) {
        const double share = (inverse_z(i) - inverse_z(0)) * s.inverse_area;
        made.right -= share * subpixels * s.dy[i];
        made.down += share * subpixels * s.dx[i];
        made.ahead += share * static_cast<double>(edge(s, i, 0, 0));
    }
    const auto [least, most] = std::minmax({s.at[0]->inverse_z, s.at[1]->inverse_z, s.at[2]->inverse_z});
    made.nearest = 1.0f / most;
    made.farthest = 1.0f / least;
    return made;
}

DepthOfPixels depth_along_rays(const LensRays& rays, const std::array<glm::dvec3, 3>& at, const glm::dvec3& normal) {
    DepthOfPixels made{.right = normal.x, .down = normal.y, .ahead = normal.z, .offset = glm::dot(normal, at[0])};
    const auto length = [&](const glm::dvec3& p) { return rays.is_wide() ? glm::length(p) : p.z; };
    const auto [nearest, farthest] = std::minmax({length(at[0]), length(at[1]), length(at[2])});
    // Inside of a triangle there may be what is nearer to the eye than its corners.
    made.nearest = static_cast<float>(rays.is_wide() ? std::abs(made.offset) / glm::length(normal) : nearest);
    made.farthest = static_cast<float>(farthest);
    return made;
}

}  // namespace

std::array<glm::dvec3, 3> corners_of(const ViewGeometry& geometry, const ScreenTriangle& triangle) {
    const ViewDraw& draw = geometry.draws()[triangle.draw];
    std::array<glm::dvec3, 3> at;
    for (std::size_t i = 0; i < 3; ++i) {
        const Corner corner = corner_of(geometry, draw, triangle.vertices[i]);
        at[i] = corner.clipped != nullptr
                    ? corner.clipped->position
                    : glm::dvec3(draw.optical_from_local * glm::dvec4(draw.positions[corner.vertex], 1.0));
    }
    return at;
}

DepthOfPixels depth_of(const ViewGeometry& geometry, const ScreenTriangle& triangle) {
    const std::array<glm::dvec3, 3> at = corners_of(geometry, triangle);
    const glm::dvec3 normal = glm::cross(at[1] - at[0], at[2] - at[0]);
    if (geometry.rays() != nullptr) return depth_along_rays(*geometry.rays(), at, normal);
    if (normal == glm::dvec3(0.0)) return depth_of_stroke(geometry, triangle);
    const camera::Intrinsics& k = geometry.transform().intrinsics;
    DepthOfPixels made{.right = normal.x / k.fx, .down = normal.y / k.fy, .offset = glm::dot(normal, at[0])};
    made.ahead = normal.z - made.right * k.cx - made.down * k.cy;
    const auto [nearest, farthest] = std::minmax({at[0].z, at[1].z, at[2].z});
    made.nearest = static_cast<float>(nearest);
    made.farthest = static_cast<float>(farthest);
    return made;
}

}  // namespace camrig::render::software
