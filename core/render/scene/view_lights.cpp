#include "core/render/scene/view_lights.h"

#include <algorithm>
#include <cmath>

namespace camrig::render::scene {

LightInView light_in_view(const world::Light& light, const ViewTransform& view, float exposure, double lamps_hz) {
    LightInView made;
    made.color = light.color * light.intensity * exposure;
    if (light.flicker_hz == lamps_hz) made.color *= 1.0f + light.flicker_depth;
    made.towards = glm::vec3(view.optical_from_world * -light.direction);
    if (light.type == world::LightType::directional) return made;
    made.position = glm::vec3(view.optical_from_world * (light.position - view.eye));
    made.direction = glm::vec3(view.optical_from_world * light.direction);
    made.inverse_range2 = light.range > 0.0f ? 1.0f / (light.range * light.range) : 0.0f;
    if (light.type == world::LightType::spot) {
        const float inner = std::cos(light.inner_cone_rad), outer = std::cos(light.outer_cone_rad);
        made.spot_scale = 1.0f / std::max(0.001f, inner - outer);
        made.spot_offset = -outer * made.spot_scale;
    }
    return made;
}

SurroundingsInView surroundings_in_view(const world::LightProbe& probe, const ViewTransform& view) {
    return {probe.mean, probe.along * glm::transpose(glm::mat3(view.optical_from_world))};
}

AmbientInView ambient_in_view(const world::Environment& environment, float exposure, const ViewTransform& view) {
    return {.up = glm::vec3(view.optical_from_world * glm::dvec3(0.0, 0.0, 1.0)),
            .sky = environment.ambient_sky * exposure,
            .ground = environment.ambient_ground * exposure,
            .exposure = exposure};
}

}  // namespace camrig::render::scene
