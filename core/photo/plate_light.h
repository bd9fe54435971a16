#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "core/base/result.h"
#include "core/photo/picture.h"

namespace camrig::photo {

/// Error invalid_argument: it is not within the photo.
Result<void> check_region(const Picture& picture, const Region& region);

/// Mean linear light of a region, per channel. Errors: outside of the photo, or where more than one pixel in a hundred
/// is clipped, of which nobody knows how bright it was.
Result<glm::dvec3> mean_light(const Picture& picture, const Region& region);

/// The light of a place, where level ground in the sun has 1 in each channel.
struct PlateLight {
    glm::dvec3 sky{0.25};     ///< ambient from above: what is left in the shadow
    glm::dvec3 ground{0.25};  ///< from below: a quarter of what falls on the ground, which nobody measured
    glm::dvec3 sun{0.0};      ///< color * intensity of the directional light
    glm::dvec3 gain{1.0};     ///< by which a drawn colour is multiplied to be the photo's
};

/// Where nothing was measured: what a clear sky leaves in the shadow of what its sun and it give together.
inline constexpr glm::dvec3 clear_sky{0.22, 0.25, 0.31};

/// lit, shaded: linear light of one level surface in the sun and in full shadow. `light_direction`: the way the sun's
/// light travels. `white`: linear light of something level in the sun that reflects `reflectance` of all colours.
/// Errors: a shadow that is no darker than the sun, a sun below 2 degrees.
Result<PlateLight> match_light(const glm::dvec3& lit, const glm::dvec3& shaded, const glm::dvec3& light_direction,
                               const std::optional<glm::dvec3>& white, double reflectance);

/// Noise of a photo: a code of level c has the variance k c + read^2, in codes; rounding to codes is not in it.
struct PlateNoise {
    double k = 0.0, read = 0.0;
    int blocks = 0;  ///< flat ones that it was read off
};
/// From the flat parts of the photo, which it finds: blocks of 8x8 less their plane, of each level those of least
/// variance. Error: hardly anything is flat.
Result<PlateNoise> fit_noise(const Picture& picture);

/// How soft an edge is: standard deviation of the Gaussian that blurs it, beyond the pixel's own area (1/12), in linear
/// light. Error: not one straight edge in the region.
Result<double> fit_edge(const Picture& picture, const Region& region);

}  // namespace camrig::photo
