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

world::LightProbe surroundings_in_view(const world::LightProbe& probe, const ViewTransform& view) {
    const glm::mat3 turn(view.optical_from_world), back = glm::transpose(turn);
    world::LightProbe made{probe.mean, probe.along * back, {}};
    for (glm::length_t c = 0; c < 3; ++c) {
        // The sum of products of n is n * of * n.
        const auto& p = probe.products;
        const float xy = 0.5f * p[0][c], yz = 0.5f * p[1][c], xz = 0.5f * p[2][c], zz = p[4][c];
        const glm::mat3 of(p[3][c] - zz, xy, xz, xy, -p[3][c] - zz, yz, xz, yz, 2.0f * zz);
        const glm::mat3 now = turn * of * back;
        made.products[0][c] = 2.0f * now[0][1];
        made.products[1][c] = 2.0f * now[1][2];
        made.products[2][c] = 2.0f * now[0][2];
        made.products[3][c] = 0.5f * (now[0][0] - now[1][1]);
        made.products[4][c] = 0.5f * now[2][2];
    }
    return made;
}

AmbientInView ambient_in_view(const world::Environment& environment, float exposure, const ViewTransform& view) {
    return {.up = glm::vec3(view.optical_from_world * glm::dvec3(0.0, 0.0, 1.0)),
            .sky = environment.ambient_sky * exposure,
            .ground = environment.ambient_ground * exposure,
            .exposure = exposure};
}

}  // namespace camrig::render::scene
