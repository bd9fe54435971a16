#pragma once

#include <cstdint>

#include "core/render/scene/lens_view.h"
#include "core/render/software/canvas.h"

namespace camrig::render::software {

/// Which way each pixel of a camera with a lens looks, in its optical frame: a ray reaches a point at (x, y, 1) times
/// the point's z; that of a wide lens (LensView::is_wide) has length 1 and reaches it at its distance from the eye.
/// What sees nothing (LensView::blind) looks the way of a pixel beside it.
///
/// Made once for the optics of a camera, in 30 to 50 nanoseconds a pixel; 8 bytes for each, or 12. Immutable; any
/// thread.
class LensRays {
public:
    /// Pixels are looked at together in tiles, a group of lanes wide and as high, and these in blocks of tiles.
    static constexpr int tile_side = lane_count, block_side = tile_side * lane_count;

    /// wide: with instructions for all lanes at once (has_wide_lanes).
    LensRays(const scene::LensView& lens, bool wide);

    bool is_wide() const { return is_wide_; }
    PixelRect whole() const { return {0, 0, size_.width, size_.height}; }

    /// Coordinates of the rays. The picture goes on for a group of lanes and a row, so that there is a next one.
    struct Coordinates {
        Rows<const float> x, y, z;
    };
    Coordinates rays() const { return {rows_of(x_), rows_of(y_), {z_.rows().data, is_wide_ ? z_.rows().stride : 0}}; }

    /// The smallest and the largest coordinates in each cell of a grid; its rows are whole groups of lanes. Cells
    /// beside the picture hold none.
    struct Grid {
        Plane<float> low_x, low_y, low_z, high_x, high_y, high_z;

        Grid() = default;
        explicit Grid(ImageSize cells);
        void add(int column, int row, const glm::vec3& ray);
    };
    const Grid& tiles() const { return tiles_; }
    const Grid& blocks() const { return blocks_; }
    /// No coordinate of a ray differs by more than this from that of its pixel's centre, anywhere in the pixel.
    const glm::vec3& pixel_reach() const { return pixel_reach_; }

private:
    static Rows<const float> rows_of(const Plane<float>& plane) { return {plane.rows().data, plane.rows().stride}; }
    void copy_row(int from, int to);
    void find_bounds();

    ImageSize size_;
    bool is_wide_ = false;
    Plane<float> x_, y_, z_;  ///< z: of a lens that is not wide, one row for all
    Grid tiles_, blocks_;
    glm::vec3 pixel_reach_{0.0f};
};

}  // namespace camrig::render::software
