#include "core/truth/ground.h"

#include <algorithm>
#include <cmath>

#include "core/camera/camera_model.h"

namespace camrig::truth {
namespace {

constexpr double thickness_m = 0.05;

}  // namespace

std::vector<std::int64_t> seen_ground(const GroundGrid& grid, const world::CameraSpec& spec, const camera::Pose& pose,
                                      const frame::Frame& depth) {
    const auto model = camera::CameraModel::create(spec.size, spec.intrinsics, spec.lens).value();
    const glm::dmat3 world_from_optical = camera::world_from_optical_rotation(pose);
    const auto* const metres = reinterpret_cast<const float*>(depth.bytes().data());
    const auto shows_ground = [&](const glm::dvec2& pixel) {
        // Not round: it takes -0.5, which is in the picture, to -1.
        const double x = std::min(std::floor(pixel.x + 0.5), spec.size.width - 1.0);
        const double y = std::min(std::floor(pixel.y + 0.5), spec.size.height - 1.0);
        const auto ray = model.ray({x, y});
        const double z = metres[static_cast<std::ptrdiff_t>(y) * spec.size.width + static_cast<std::ptrdiff_t>(x)];
        if (!ray || !std::isfinite(z) || ray->z == 0.0) return false;
        const glm::dvec3 seen = pose.position + world_from_optical * *ray * (z / ray->z);
        return std::abs(seen.z - grid.height_m) <= thickness_m;
    };
    const auto first = [&](double at) {
        return static_cast<std::int32_t>(std::ceil((at - grid.range_m) / grid.cell_m));
    };
    // Cells have numbers of 32 bits.
    if (std::max(std::abs(pose.position.x), std::abs(pose.position.y)) / grid.cell_m > 1e9) return {};
    const auto cells = static_cast<std::int32_t>(2.0 * grid.range_m / grid.cell_m);
    const std::int32_t column0 = first(pose.position.x), row0 = first(pose.position.y);
    CHECK(std::int64_t{cells} * cells <= max_ground_cells);
    std::vector<std::int64_t> seen;
    for (std::int32_t row = row0; row < row0 + cells; ++row) {
        for (std::int32_t column = column0; column < column0 + cells; ++column) {
            const glm::dvec3 middle((column + 0.5) * grid.cell_m, (row + 0.5) * grid.cell_m, grid.height_m);
            const auto pixel = model.project(glm::transpose(world_from_optical) * (middle - pose.position));
            if (pixel && model.in_image(*pixel) && shows_ground(*pixel)) seen.push_back(cell_number(column, row));
        }
    }
    return seen;
}

}  // namespace camrig::truth
