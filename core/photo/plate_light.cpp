#include "core/photo/plate_light.h"

#include <string>

namespace camrig::photo {
namespace {

constexpr double ground_share = 0.25;
constexpr double least_elevation_sin = 0.035;

}  // namespace

Result<void> check_region(const Picture& picture, const Region& region) {
    if (region.width < 1 || region.height < 1 || region.x < 0 || region.y < 0 ||
        region.x > picture.size.width - region.width || region.y > picture.size.height - region.height)
        return invalid("is not within the photo of " + picture.size.to_string());
    return {};
}

Result<glm::dvec3> mean_light(const Picture& picture, const Region& region) {
    if (auto good = check_region(picture, region); !good) return std::unexpected(good.error());
    glm::dvec3 sum(0.0);
    int clipped = 0;
    for (int y = region.y; y < region.y + region.height; ++y)
        for (int x = region.x; x < region.x + region.width; ++x) {
            bool is_clipped = false;
            for (int channel = 0; channel < 3; ++channel) {
                const int code = picture.code(x, y, channel);
                is_clipped |= code == 0 || code == 255;
                sum[channel] += linear_of(code);
            }
            clipped += is_clipped;
        }
    const int count = region.width * region.height;
    if (100 * clipped > count)
        return invalid("is clipped there (codes 0 or 255); choose a place that is neither black nor white");
    return sum / double(count);
}

Result<PlateLight> match_light(const glm::dvec3& lit, const glm::dvec3& shaded, const glm::dvec3& light_direction,
                               const std::optional<glm::dvec3>& white, double reflectance) {
    const double sine = -glm::normalize(light_direction).z;
    if (sine < least_elevation_sin)
        return invalid("sun: stands below 2 degrees over the horizon, and lights no level ground");
    if (!(reflectance > 0.0 && reflectance <= 1.0)) return invalid("reflectance: must be over 0 and at most 1");
    PlateLight light;
    light.sky = shaded / lit;
    for (int channel = 0; channel < 3; ++channel)
        if (!(light.sky[channel] < 1.0))
            return invalid("shaded: is no darker than lit; give the same surface in shadow and in the sun");
    light.sun = (1.0 - light.sky) / sine;
    light.ground = glm::dvec3(ground_share);
    if (white) light.gain = *white / reflectance;
    return light;
}

}  // namespace camrig::photo
