#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/base/result.h"
#include "core/camera/camera_model.h"
#include "core/world/camera_sampling.h"

namespace camrig::render {

/// One pinhole picture: a rectangle of the source and the frustum that is drawn into it.
struct SourceTile {
    glm::dmat3 tile_from_optical{1.0};
    camera::Intrinsics intrinsics{};  ///< in the tile's own pixels
    ImageSize size{};
    int x = 0;  ///< of its first pixel in the source
    int y = 0;
};

/// How the picture of a camera with a lens comes out of pinhole pictures: which of them are drawn, into which parts of
/// one source picture, and where in the source each pixel of the camera looks.
///
/// `warp`: one pinhole picture with the camera's own axis, larger than the camera's. `cube`: up to six faces with 90
/// deg between their axes, for fields that no single plane holds. Of each only what the camera sees, and a border for
/// the filter. No side of a texel is longer than a pixel within 118 deg of the axis, so nothing is under-sampled.
///
/// The map is exact: every pixel's ray is taken from CameraModel in double, and kept as a place in the source in fixed
/// point with 16 binary places, so its rounding is the same 8e-6 texels everywhere, far from the float's 5e-4.
struct LensPlan {
    /// A pixel that sees nothing: beyond the fold of the lens.
    static constexpr glm::ivec2 nowhere{-INT32_MAX, -INT32_MAX};
    static constexpr int fraction_bits = 16;

    world::LensMethod method = world::LensMethod::warp;  ///< never automatic
    ImageSize size;                                      ///< of the camera's picture
    ImageSize source;
    std::vector<SourceTile> tiles;
    /// Per pixel: 65536 times the source place, texel centres at integers.
    std::vector<glm::ivec2> map;
    /// Per pixel: how far in the source (texels) one pixel to the right (x, y) and down (z, w) is; where supersampling
    /// takes its samples.
    std::vector<glm::vec4> footprint;
    /// Per pixel: z in the optical frame per z in the tile, of the texel that is nearest; empty: 1 everywhere.
    std::vector<float> depth_factor;

    /// Longest footprint, in pixels of the middle of a picture without distortion. Longer ones exist only at a fold.
    static constexpr double max_footprint = 8.0;
};

struct LensPlanLimits {
    int max_side = 16384;                             ///< of the source
    std::int64_t max_texels = std::int64_t{1} << 26;  ///< of the source
};

/// Pictures through a lens have at most so many pixels: the plan takes 32 bytes for each while it is made.
inline constexpr std::int64_t max_lens_pixels = std::int64_t{1} << 25;

/// Takes 0.2 to 0.6 microseconds per pixel on one core (rays are shared among a few threads of its own).
Result<LensPlan> make_lens_plan(const camera::CameraModel& camera, const world::LensSampling& sampling,
                                const LensPlanLimits& limits);

}  // namespace camrig::render
