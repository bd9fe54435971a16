#include "core/world/clouded_sky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "core/base/portable_math.h"
#include "core/world/shape_model.h"

namespace camrig::world {
namespace {

using daylight::Clouds;
constexpr double earth_m = 6371e3;
/// At such a distance haze leaves 1/e of a cloud's contrast.
constexpr double clear_m = 16e3;
/// Shares of the sun's light: what a surface sends that faces the sun and what it has less when it does not, and what
/// comes through where nothing is over it, from all sides and from before the sun.
constexpr float facing = 0.2f, turning = 0.3f, through = 0.1f, before_sun = 0.6f;
/// Of the sky's and the ground's light, at the base and more of it at the top.
constexpr float sky_low = 0.32f, sky_more = 0.38f, ground_low = 0.45f, ground_more = -0.3f;

double distance_m(double up) {
    const double over = earth_m * up, base = daylight::cloud_base_m;
    return std::sqrt(over * over + 2.0 * earth_m * base) - over;
}
/// What haze leaves of clouds in the direction of a sine of elevation; none on the horizon.
float clear_air(double up) {
    const auto left = [](double distance) { return portable::exp(-distance / clear_m); };
    const double least = left(distance_m(0.0));
    return static_cast<float>((left(distance_m(up)) - least) / (1.0 - least));
}

/// More for thin clouds near the sun.
float glow_beside(float cos_sun) {
    return 0.1f / (1.1f - cos_sun);
}

/// 1.1 degrees higher: what the horizon is lower by, seen from the clouds' base.
glm::dvec3 raised(const glm::dvec3& to_sun) {
    constexpr double dip = 0.0194;
    const double level = std::sqrt(std::max(0.0, 1.0 - to_sun.z * to_sun.z));
    const double elevation = std::min(portable::atan2(to_sun.z, level) + dip, 0.5 * std::numbers::pi);
    const double scale = level > 0.0 ? portable::cos(elevation) / level : 0.0;
    return glm::normalize(glm::dvec3(to_sun.x * scale, to_sun.y * scale, portable::sin(elevation)));
}

/// Clouds explain so much of what is overcast; the rest is a veil that is everywhere.
double veil_of(const DaylightSpec& spec) {
    const double clouds = cloud_share(spec);
    return std::max(0.0, (spec.overcast - clouds) / (1.0 - clouds));
}

/// sRGB codes of linear values from 0 to 1, by 4096 steps.
class Encoder {
public:
    Encoder() {
        for (std::size_t i = 0; i < codes_.size(); ++i) {
            const double linear = static_cast<double>(i) / static_cast<double>(codes_.size() - 1);
            const double code =
                linear <= 0.0031308 ? 12.92 * linear : 1.055 * portable::exp(portable::log(linear) / 2.4) - 0.055;
            codes_[i] = static_cast<std::uint8_t>(255.0 * code + 0.5);
        }
    }
    std::uint8_t operator()(float linear) const {
        return codes_[static_cast<std::size_t>(std::clamp(linear, 0.0f, 1.0f) * 4095.0f + 0.5f)];
    }

private:
    std::array<std::uint8_t, 4096> codes_{};
};

/// Where between two neighbours of a grid something is.
struct Between {
    std::size_t first;
    float share;
};
Between place_between(int number, int of, int grid) {
    const float at = (static_cast<float>(number) + 0.5f) * static_cast<float>(grid) / static_cast<float>(of);
    const auto first = static_cast<std::size_t>(at);
    return {first, at - static_cast<float>(first)};
}

}  // namespace

double cloud_share(const DaylightSpec& spec) {
    return spec.clouds ? double{*spec.clouds} : spec.overcast;
}

CloudedSky::CloudedSky(const glm::dvec3& to_sun, const DaylightSpec& spec, double per_lux)
    : whole_(to_sun, {.turbidity = spec.turbidity, .overcast = spec.overcast}),
      gaps_(to_sun, {.turbidity = spec.turbidity, .overcast = veil_of(spec)}),
      overcast_(to_sun, {.turbidity = spec.turbidity, .overcast = 1.0}),
      clouds_(daylight::clouds_of(cloud_share(spec))),
      per_lux_(per_lux) {
    const double share = cloud_share(spec);
    closed_share_ = static_cast<float>(share * share * share * share);
    const glm::dvec3 high = raised(to_sun);
    to_sun_ = glm::vec3(high);
    const daylight::Sky up_there(high, {.turbidity = spec.turbidity, .overcast = veil_of(spec)});
    // The lower the sun, the more clouds are in each other's shadow.
    const double reached = 1.0 / (1.0 + 0.35 * share * (1.0 / std::max(high.z, 0.03) - 1.0));
    sun_ = glm::vec3(up_there.sun_lux() * (reached * per_lux));
    sky_ = glm::vec3(up_there.sky_lux() * per_lux);
    const glm::dvec3 level = gaps_.sky_lux() + gaps_.sun_lux() * std::max(to_sun.z, 0.0);
    ground_ = spec.ground * glm::vec3(level * per_lux);
}

glm::vec3 CloudedSky::behind(const glm::dvec3& towards) const {
    // On the horizon all is seen at once: it is that of the mixed sky.
    return glm::mix(glm::vec3(whole_.from(towards) * per_lux_), glm::vec3(gaps_.from(towards) * per_lux_),
                    clear_air(towards.z));
}

glm::vec3 CloudedSky::closed(double up) const {
    const double level = std::sqrt(std::max(0.0, 1.0 - up * up));
    return glm::vec3(overcast_.from({level, 0.0, up}) * per_lux_);
}

glm::vec3 CloudedSky::light(float of_sun, float height) const {
    return of_sun * sun_ + (sky_low + sky_more * height) * sky_ + (ground_low + ground_more * height) * ground_;
}

glm::vec3 CloudedSky::brightest(const glm::dvec3& towards) const {
    const float most_of_sun =
        facing + turning + through + before_sun * glow_beside(glm::dot(glm::vec3(towards), to_sun_));
    const glm::vec3 most = glm::max(light(most_of_sun, 0.0f), light(most_of_sun, 1.0f));
    const glm::vec3 sky = behind(towards), clouds = glm::mix(most, closed(towards.z), closed_share_);
    return glm::max(sky, glm::mix(sky, clouds, clear_air(towards.z)));
}

Image CloudedSky::picture() const {
    static const Encoder encoded;
    constexpr int width = Clouds::columns, height = Clouds::rows;
    // A texel is what is seen there, divided by what the renderer mixes there of the colours of the model's corners.
    constexpr int grid_columns = daylit_sky_fineness * sky_columns, grid_rows = daylit_sky_fineness * sky_rows;
    struct Corner {
        glm::vec3 clear, most;  ///< behind the clouds, and the corner's colour
    };
    std::vector<Corner> corners;
    for (int row = 0; row <= grid_rows; ++row)
        for (int column = 0; column <= grid_columns; ++column) {
            const glm::dvec3 towards = sky_corner(column, grid_columns, row, grid_rows);
            corners.push_back({behind(towards), glm::max(brightest(towards), glm::vec3(1e-20f))});
        }
    std::vector<Between> places;
    std::vector<glm::vec2> pans;
    for (int column = 0; column < width; ++column) {
        places.push_back(place_between(column, width, grid_columns));
        const double pan = Clouds::pan_of(column);
        pans.emplace_back(portable::cos(pan), portable::sin(pan));
    }

    Image image{.size = {width, height}, .rgba = std::vector<std::uint8_t>(std::size_t{4} * width * height, 255)};
    std::vector<Corner> line(grid_columns + 1);
    // The lowest row stays white: it is all that is below the horizon.
    for (int row = 1; row < height; ++row) {
        const auto [below, share] = place_between(row, height, grid_rows);
        for (std::size_t i = 0; i < line.size(); ++i) {
            const Corner& low = corners[below * line.size() + i];
            const Corner& high = corners[(below + 1) * line.size() + i];
            line[i] = {glm::mix(low.clear, high.clear, share), glm::mix(low.most, high.most, share)};
        }
        const double elevation = Clouds::elevation_of(row), up = portable::sin(elevation);
        const auto level = static_cast<float>(portable::cos(elevation)), rise = static_cast<float>(up);
        const float air = clear_air(up);
        const glm::vec3 closed_light = closed(up) * closed_share_;
        const std::span<const daylight::CloudSight> sights = clouds_->row(row);
        std::uint8_t* texel = image.rgba.data() + std::size_t{4} * width * static_cast<std::size_t>(row);
        for (std::size_t column = 0; column < width; ++column, texel += 4) {
            const auto [first, part] = places[column];
            const auto between = [&](glm::vec3 Corner::* of) {
                return line[first].*of + (line[first + 1].*of - line[first].*of) * part;
            };
            glm::vec3 seen = between(&Corner::clear);
            const daylight::CloudSight& cloud = sights[column];
            if (cloud.opacity > 0) {
                constexpr float unit = 1.0f / 255.0f;
                const float opacity = unit * static_cast<float>(cloud.opacity);
                const glm::vec3 towards(level * pans[column].x, level * pans[column].y, rise);
                const glm::vec3 outward(cloud.outward[0], cloud.outward[1], cloud.outward[2]);
                const float faces = glm::dot(outward, to_sun_) * (1.0f / 127.0f);
                const float thin = 1.0f / (1.0f + 6.0f * unit * static_cast<float>(cloud.depth));
                const float of_sun =
                    std::max(0.0f, facing + turning * faces) +
                    thin * (through + before_sun * glow_beside(glm::dot(towards, to_sun_)) * (1.0f - 0.8f * opacity));
                const glm::vec3 shines =
                    light(of_sun, unit * static_cast<float>(cloud.height)) * (1.0f - closed_share_) + closed_light;
                seen += (shines - seen) * (opacity * air);
            }
            seen = glm::min(seen / between(&Corner::most), glm::vec3(1.0f));
            for (int i = 0; i < 3; ++i) texel[i] = encoded(seen[i]);
        }
    }
    return image;
}

}  // namespace camrig::world
