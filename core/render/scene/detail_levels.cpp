#include "core/render/scene/detail_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <meshoptimizer.h>

namespace camrig::render::scene {
namespace {

constexpr std::size_t min_triangles = 256;  ///< below, a draw costs more than its triangles
constexpr float first_error = 0.001f;       ///< of the mesh's extent: 2 mm of a person
/// Each with so many times the error of the one before: a mesh is drawn with up to that much less error than allowed,
/// so the steps are small.
constexpr float step = 1.4142136f;
constexpr int max_levels = 12;
constexpr double worthwhile = 0.85;  ///< of the triangles of the level before, at most

}  // namespace

std::vector<DetailLevel> make_detail_levels(const world::Primitive& primitive) {
    std::vector<DetailLevel> levels;
    if (primitive.topology != world::Topology::triangles || primitive.joints.empty() || !primitive.targets.empty() ||
        primitive.indices.size() < 3 * min_triangles) {
        return levels;
    }
    const float* positions = &primitive.positions.front().x;
    const float extent = meshopt_simplifyScale(positions, primitive.positions.size(), sizeof(glm::vec3));
    std::size_t last_count = primitive.indices.size();
    float error = first_error;
    for (int n = 0; n < max_levels; ++n, error *= step) {
        DetailLevel level;
        level.indices.resize(primitive.indices.size());
        float made = 0.0f;
        const std::size_t count =
            meshopt_simplify(level.indices.data(), primitive.indices.data(), primitive.indices.size(), positions,
                             primitive.positions.size(), sizeof(glm::vec3), 0, error, 0, &made);
        if (count == 0) break;
        if (static_cast<double>(count) > worthwhile * static_cast<double>(last_count)) continue;
        level.indices.resize(count);
        level.error = made * extent;
        last_count = count;
        levels.push_back(std::move(level));
    }
    return levels;
}

double detail_error_scale(const world::Box& bind, const world::Box& bounds, const glm::dmat4& world_from_local) {
    const double growth = glm::length(glm::dvec3(bounds.max) - glm::dvec3(bounds.min)) /
                          std::max(1e-9, double{glm::length(bind.max - bind.min)});
    return growth * std::cbrt(std::abs(glm::determinant(glm::dmat3(world_from_local))));
}

double detail_error_px(const ViewTransform& view, const glm::dmat4& optical_from_local, const world::Box& box,
                       double error) {
    // Across the ray a length e at depth z shows as e f / z, slanted away from the middle by up to |p| / z more. Both
    // factors are largest at corners of the box: depth is linear, and |p| / z <= c is a cone, so convex.
    double nearest = std::numeric_limits<double>::infinity(), slant = 1.0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec4 local((corner & 1 ? box.max : box.min).x, (corner & 2 ? box.max : box.min).y,
                               (corner & 4 ? box.max : box.min).z, 1.0);
        const glm::dvec3 p(optical_from_local * local);
        if (!(p.z > 0.0)) return std::numeric_limits<double>::infinity();
        nearest = std::min(nearest, p.z);
        slant = std::max(slant, glm::length(p) / p.z);
    }
    return error * std::max(view.intrinsics.fx, view.intrinsics.fy) / nearest * slant;
}

}  // namespace camrig::render::scene
