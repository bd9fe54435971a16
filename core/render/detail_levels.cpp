#include "core/render/detail_levels.h"

#include <algorithm>
#include <limits>

#include <meshoptimizer.h>

namespace camrig {
namespace {

constexpr std::size_t min_triangles = 256;  ///< below, a draw costs more than its triangles
constexpr float first_error = 0.001f;       ///< of the mesh's extent: 2 mm of a person
constexpr int max_levels = 6;               ///< each with twice the error of the one before
constexpr double worthwhile = 0.85;         ///< of the triangles of the level before, at most

}  // namespace

std::vector<DetailLevel> make_detail_levels(const Primitive& primitive) {
    std::vector<DetailLevel> levels;
    if (primitive.topology != Topology::triangles || primitive.joints.empty() || !primitive.targets.empty() ||
        primitive.indices.size() < 3 * min_triangles) {
        return levels;
    }
    const float* positions = &primitive.positions.front().x;
    const float extent = meshopt_simplifyScale(positions, primitive.positions.size(), sizeof(glm::vec3));
    std::size_t last_count = primitive.indices.size();
    float error = first_error;
    for (int n = 0; n < max_levels; ++n, error *= 2.0f) {
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

double detail_error_px(const ViewTransform& view, glm::dvec3 centre, double radius, double error) {
    const double z = centre.z - radius;
    if (!(z > 0.0)) return std::numeric_limits<double>::infinity();
    // Across the ray a length e at distance r shows as e f / z, slanted away from the middle by up to r / z more.
    const double focal_px = std::max(view.intrinsics.fx, view.intrinsics.fy);
    return error * focal_px / z * (glm::length(centre) + radius) / z;
}

}  // namespace camrig
