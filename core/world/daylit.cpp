#include "core/world/daylit.h"

#include <algorithm>

#include "core/base/portable_math.h"
#include "core/daylight/sky.h"
#include "core/daylight/sun.h"
#include "core/world/clouded_sky.h"
#include "core/world/shape_model.h"

namespace camrig::world {
namespace {

/// How high cameras look when they look at the sky: the background is the mean of it up to there.
constexpr double horizon_rad = 0.25;

glm::dvec3 light_direction(const DaylightSpec& spec) {
    if (spec.time.empty())
        return daylight::light_direction({spec.azimuth_rad.value(), spec.elevation_rad.value()}, spec.north_rad);
    // Was read before: a time that cannot be read has come no further than its file.
    const double instant = daylight::read_instant(spec.time).value();
    return daylight::light_direction(daylight::sun_at(instant, spec.latitude_deg, spec.longitude_deg), spec.north_rad);
}

daylight::Sky sky_of(const DaylightSpec& spec) {
    return {-light_direction(spec), {.turbidity = spec.turbidity, .overcast = spec.overcast}};
}

glm::dvec3 near_horizon(const daylight::Sky& sky) {
    constexpr int pieces = 48;
    glm::dvec3 sum(0.0);
    for (int i = 0; i < pieces; ++i) {
        const double pan = 2.0 * std::numbers::pi * i / pieces, up = horizon_rad * (i % 4 + 0.5) / 4;
        sum += sky.from(
            {portable::cos(up) * portable::cos(pan), portable::cos(up) * portable::sin(pan), portable::sin(up)});
    }
    return sum / double(pieces);
}

}  // namespace

void apply_daylight(Environment& environment, std::vector<Light>& lights) {
    const DaylightSpec& spec = *environment.daylight;
    if (!environment.lux) environment.lux = daylight_lux;
    const double per_lux = 1.0 / *environment.lux;
    const daylight::Sky sky = sky_of(spec);
    auto sun = std::ranges::find(lights, sun_name, &Light::name);
    if (sun == lights.end()) {
        lights.insert(lights.begin(), {.name = sun_name, .group = {}});
        sun = lights.begin();
    }
    sun->type = LightType::directional;
    sun->direction = light_direction(spec);
    const double brightest = std::max({sky.sun_lux().r, sky.sun_lux().g, sky.sun_lux().b});
    sun->color = brightest > 0.0 ? glm::vec3(sky.sun_lux() / brightest) : glm::vec3(1.0f);
    sun->intensity = static_cast<float>(brightest * per_lux);
    environment.ambient_sky = glm::vec3(sky.sky_lux() * per_lux);
    const double height = std::max(-sun->direction.z, 0.0);
    environment.ambient_ground = spec.ground * glm::vec3((sky.sky_lux() + sky.sun_lux() * height) * per_lux);
    environment.background = glm::vec3(near_horizon(sky) * per_lux);
}

ModelRef daylit_sky(const Environment& environment, double radius_m) {
    const DaylightSpec& spec = *environment.daylight;
    const daylight::Sky sky = sky_of(spec);
    const double per_lux = 1.0 / environment.lux.value();
    const glm::vec3 haze(near_horizon(sky) * per_lux);
    const auto model = [&](const auto& above, Image picture = {}) {
        return sky_model(
            radius_m, daylit_sky_fineness,
            [&](const glm::dvec3& towards) { return towards.z < 0.0 ? haze : above(towards); }, std::move(picture));
    };
    const double clouds = cloud_share(spec);
    if (clouds > 0.0 && clouds < 1.0) {
        const CloudedSky clouded(-light_direction(spec), spec, per_lux);
        return model([&](const glm::dvec3& towards) { return clouded.brightest(towards); }, clouded.picture());
    }
    const auto all_of = [&](const daylight::Sky& smooth) {
        return model([&](const glm::dvec3& towards) { return glm::vec3(smooth.from(towards) * per_lux); });
    };
    if (clouds <= 0.0) return all_of(sky);
    return all_of({-light_direction(spec), {.turbidity = spec.turbidity, .overcast = 1.0}});
}

void show_sky(StaticSet& statics) {
    for (auto* objects : {&statics.objects, &statics.hidden})
        for (Instance& object : *objects) {
            if (object.info->model->sky_radius_m <= 0.0) continue;
            auto info = std::make_shared<ObjectInfo>(*object.info);
            info->model = daylit_sky(statics.environment, info->model->sky_radius_m);
            object.info = std::move(info);
        }
}

}  // namespace camrig::world
