#pragma once

#include <cstdint>
#include <vector>

#include "core/camera/pose.h"
#include "core/frame/frame.h"
#include "core/world/camera_spec.h"

namespace camrig::truth {

/// The level ground in square cells; cell (column, row) begins at (column, row) times cell_m in the world.
struct GroundGrid {
    double cell_m = 0.5;
    double range_m = 30.0;  ///< so far from a camera, along x and along y
    double height_m = 0.0;  ///< z in the world
};

/// Most cells that are looked at for one camera.
inline constexpr std::int64_t max_ground_cells = 1'000'000;

/// A cell as one number.
constexpr std::int64_t cell_number(std::int32_t column, std::int32_t row) {
    return (std::int64_t{row} << 32) + column;
}

/// Of which cells a camera sees the middle: its pixel shows something at the height of the ground, within 5 cm.
/// Rising. depth: its depth picture. The grid has at most max_ground_cells.
std::vector<std::int64_t> seen_ground(const GroundGrid& grid, const world::CameraSpec& spec, const camera::Pose& pose,
                                      const frame::Frame& depth);

}  // namespace camrig::truth
