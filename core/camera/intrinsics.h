#pragma once

#include <glm/glm.hpp>

#include "core/base/field_table.h"
#include "core/base/image_size.h"
#include "core/base/result.h"

namespace camrig::camera {

/// The pinhole part of a camera, in pixels; pixel centres are at integer coordinates (OpenCV), so the middle of an
/// image is cx = (width - 1) / 2.
struct Intrinsics {
    double fx = 1.0;
    double fy = 1.0;
    double cx = 0.0;
    double cy = 0.0;
    friend bool operator==(const Intrinsics&, const Intrinsics&) = default;
};
FieldTable<Intrinsics> fields_of(std::type_identity<Intrinsics>);

/// Square pixels, centred, with the given full vertical (or horizontal) field of view, measured edge to edge of the
/// image (height pixels, not height - 1). An angle outside (0.01, 179.9) deg, or NaN, is invalid_argument.
Result<Intrinsics> intrinsics_from_vfov(ImageSize size, double vfov_rad);
Result<Intrinsics> intrinsics_from_hfov(ImageSize size, double hfov_rad);

/// Refuses what no camera can have: not finite, focal length not positive, principal point more than 1e6 pixels away,
/// or a field of view outside (0.00001, 179.9) deg in either direction. Whatever intrinsics_from_vfov or _hfov makes
/// has at least the lower bound in the other direction too, up to a side ratio of 1000.
Result<void> check_intrinsics(ImageSize size, const Intrinsics& intrinsics);

/// On the way from one to another, as a zoom lens runs: focal lengths by a constant factor in equal times, the
/// principal point in a straight line. share: 0 to 1.
Intrinsics between(const Intrinsics& from, const Intrinsics& to, double share);

/// Full fields of view of the pinhole part, edge to edge, radians.
double vfov_rad(ImageSize size, const Intrinsics& intrinsics);
double hfov_rad(ImageSize size, const Intrinsics& intrinsics);

}  // namespace camrig::camera
