#pragma once

#include <memory>

#include <glm/glm.hpp>

#include "core/daylight/clouds.h"
#include "core/daylight/sky.h"
#include "core/world/daylight_spec.h"
#include "core/world/model.h"

namespace camrig::world {

/// A sky with clouds: what daylight shows between them, and what it makes of them. Colours are in multiples of the
/// scene's white.
///
/// The sun lights what faces it, passes through what is thin, most of all before the sun, and reaches their height a
/// little longer than the ground in the evening. The sky lights their tops and the ground their bases. With the
/// distance they fade into the sky over the horizon, and as they close they become the sky of an overcast day.
class CloudedSky {
public:
    /// to_sun: unit. The share of clouds is over 0 and below 1; per_lux: white of the scene in lux, inverse.
    CloudedSky(const glm::dvec3& to_sun, const DaylightSpec& spec, double per_lux);

    /// At least what can be seen in a direction, in each channel. On the horizon it is the sky without clouds.
    glm::vec3 brightest(const glm::dvec3& towards) const;
    /// What of brightest() is seen: rows from the horizon to the zenith, as sky_model() takes them.
    Image picture() const;

private:
    glm::vec3 behind(const glm::dvec3& towards) const;
    /// Of a closed cover.
    glm::vec3 closed(double up) const;
    /// A cloud's light: share of the sun's light that it sends here, height from base to top.
    glm::vec3 light(float of_sun, float height) const;

    daylight::Sky whole_, gaps_, overcast_;
    std::shared_ptr<const daylight::Clouds> clouds_;
    double per_lux_;
    float closed_share_;
    glm::vec3 to_sun_, sun_, sky_, ground_;
};

/// Of the model of a sky by daylight (sky_model).
inline constexpr int daylit_sky_fineness = 2;
/// How much of the sky clouds are, 0 to 1.
double cloud_share(const DaylightSpec& spec);

}  // namespace camrig::world
