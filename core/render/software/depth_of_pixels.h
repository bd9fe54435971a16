#pragma once

#include <array>

#include "core/render/software/geometry.h"

namespace camrig::render::software {

/// The plane of a triangle, for depth in metres along the optical axis: at pixel (x, y) it is
/// offset / (x * right + y * down + ahead). Of the corners as they are, not as they were rounded to parts of a pixel:
/// depth is right to its last bits, however steep the triangle is. Through a lens (x, y, 1) is the pixel's ray, and
/// what comes of it is how many rays it is to the plane. All that takes the camera for a pinhole is here.
struct DepthOfPixels {
    double right = 0.0, down = 0.0, ahead = 0.0, offset = 0.0;
    float nearest = 0.0f, farthest = 0.0f;  ///< of the corners: pixels of its edge may lie a little beside it
};

DepthOfPixels depth_of(const ViewGeometry& geometry, const ScreenTriangle& triangle);

/// Its corners in the optical frame.
std::array<glm::dvec3, 3> corners_of(const ViewGeometry& geometry, const ScreenTriangle& triangle);

}  // namespace camrig::render::software
