#pragma once

#include <memory>

#include "core/base/result.h"
#include "core/world/backdrop/picture_pyramid.h"

namespace camrig::world {

/// The whole sphere around a place in equirectangular projection: columns are azimuth, from +180 degrees on the left to
/// -180 on the right, rows are elevation, from +90 at the top to -90; the middle looks along the world's +x, its left
/// half is +y.
using Panorama = PicturePyramid;

/// Error: it is not twice as wide as high, or is less than 16 pixels wide.
Result<std::shared_ptr<const Panorama>> make_panorama(Image picture);

}  // namespace camrig::world
