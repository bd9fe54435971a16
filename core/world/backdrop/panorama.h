#pragma once

#include <memory>
#include <vector>

#include "core/base/result.h"
#include "core/world/backdrop/backdrop_spec.h"
#include "core/world/backdrop/picture_pyramid.h"
#include "core/world/backdrop/sparse_picture.h"

namespace camrig::world {

/// The whole sphere around a place in equirectangular projection: columns are azimuth, from +180 degrees on the left to
/// -180 on the right, rows are elevation, from +90 at the top to -90; the middle looks along the world's +x, its left
/// half is +y. Immutable.
struct Panorama {
    PicturePyramid whole;
    /// Parts of the same in finer pixels, the finest first: each has twice the columns of the next, the last twice
    /// those of `whole`. Empty: none.
    std::vector<SparsePicture> finer;
};

/// Puts a panorama together.
class PanoramaMaker {
public:
    /// What its details may take in memory, with their halves.
    static constexpr std::size_t max_detail_bytes = std::size_t{2} << 30;
    /// As long as a pixel is ten times what a lens's rays are rounded by.
    static constexpr int max_columns = 524288;

    /// finest: the largest scale of its details (one that scale_problem finds nothing wrong with); 1: there are none.
    /// Error: the picture is not twice as wide as high, or is less than 16 pixels wide.
    static Result<PanoramaMaker> create(Image whole, int finest);

    /// What is wrong with the scale of a detail of a panorama that is so wide; empty: nothing.
    static std::string scale_problem(int scale, int columns);

    /// Whether a picture of this size has room there, beside all that were asked for before; takes no memory yet.
    /// Errors have the field's path below the detail.
    Result<void> reserve(const PanoramaDetail& detail, ImageSize size, std::size_t most_bytes = max_detail_bytes);
    /// Of the size that was reserved. What was put there before it, at the same scale, is covered.
    void put(const PanoramaDetail& detail, const Image& picture);
    std::shared_ptr<const Panorama> finish();

private:
    explicit PanoramaMaker(PicturePyramid whole) { made_->whole = std::move(whole); }
    SparsePicture& level_of(int scale);

    std::shared_ptr<Panorama> made_ = std::make_shared<Panorama>();
    std::size_t bytes_ = 0;
};

}  // namespace camrig::world
