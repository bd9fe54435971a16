#pragma once

#include <algorithm>
#include <cmath>

#include "core/render/software/geometry.h"
#include "core/render/software/lanes.h"

/// shaders/lighting.glsl for CPUs: once for vertices and for groups of pixels, which only count differently.
namespace camrig::render::software {

/// One point.
struct OnePoint {
    using Number = float;
    using Vector = glm::vec3;
    static Vector vector(const glm::vec3& v) { return v; }
    static Number of(const Vector& a, const Vector& b) { return glm::dot(a, b); }
    static Number at_least(Number value, float least) { return std::max(value, least); }
    static Number limited(Number value) { return std::clamp(value, 0.0f, 1.0f); }
    static Vector unit(const Vector& v, Number length2) { return v / std::sqrt(length2); }
};

/// The points that a group of pixels shows.
struct PointGroup {
    using Number = Lanes;
    using Vector = Lanes3;
    CAMRIG_LANES static Vector vector(const glm::vec3& v) { return {lanes(v.x), lanes(v.y), lanes(v.z)}; }
    CAMRIG_LANES static Number of(const Vector& a, const Vector& b) { return dot(a, b); }
    CAMRIG_LANES static Number at_least(Number value, float least) { return max(value, lanes(least)); }
    CAMRIG_LANES static Number limited(Number value) { return clamp01(value); }
    CAMRIG_LANES static Vector unit(const Vector& v, Number length2) { return v * (1.0f / sqrt(length2)); }
};

template <typename P>
CAMRIG_LANES typename P::Vector hemisphere(const scene::AmbientInView& light, const typename P::Vector& n) {
    return P::vector(light.ground) +
           P::vector(light.sky - light.ground) * (0.5f + 0.5f * P::of(n, P::vector(light.up)));
}

/// Which way a local light lies from a point, and what share of its colour reaches it. KHR_lights_punctual.
template <typename P>
struct LightAtPoint {
    typename P::Vector towards;
    typename P::Number share;
};
template <typename P>
CAMRIG_LANES LightAtPoint<P> light_at(const scene::LightInView& light, const typename P::Vector& position) {
    using Number = typename P::Number;
    using Vector = typename P::Vector;
    const Vector towards = P::vector(light.position) - position;
    const Number distance2 = P::at_least(P::of(towards, towards), 1e-8f);
    const Vector direction = P::unit(towards, distance2);
    const Number ratio2 = distance2 * light.inverse_range2;
    const Number window = P::limited(1.0f - ratio2 * ratio2);
    const Number cone =
        P::limited(-P::of(direction, P::vector(light.direction)) * light.spot_scale + light.spot_offset);
    return {direction, window * cone * cone / distance2};
}

/// A light as it comes to points.
struct ArrivingLight {
    Lanes3 towards;  ///< unit
    Lanes3 color;
    std::span<const ShadowInView> shadows;  ///< its maps
};
/// Each light of a surface; `with_local`: not those from far away alone.
template <typename Use>
CAMRIG_LANES void each_light(const SurfaceLights& lights, bool with_local, const Lanes3& position, const Use& use) {
    for (std::size_t i = 0; i < lights.directional.size(); ++i) {
        const scene::LightInView& light = lights.directional[i];
        use(ArrivingLight{PointGroup::vector(light.towards), PointGroup::vector(light.color),
                          lights.directional_shadows[i]});
    }
    for (std::size_t i = 0; with_local && i < lights.local.size(); ++i) {
        const LightAtPoint<PointGroup> at = light_at<PointGroup>(lights.local[i], position);
        use(ArrivingLight{at.towards, PointGroup::vector(lights.local[i].color) * at.share, lights.local_shadows[i]});
    }
}

/// Everything that reaches a Lambert surface but the ambient part.
template <typename P>
CAMRIG_LANES typename P::Vector lambert(const SurfaceLights& lights, const typename P::Vector& n,
                                        const typename P::Vector& position) {
    using Vector = typename P::Vector;
    Vector sum = P::vector(glm::vec3(0.0f));
    for (const scene::LightInView& light : lights.directional)
        sum = sum + P::vector(light.color) * P::at_least(P::of(n, P::vector(light.towards)), 0.0f);
    for (const scene::LightInView& light : lights.local) {
        const LightAtPoint<P> at = light_at<P>(light, position);
        sum = sum + P::vector(light.color) * (at.share * P::at_least(P::of(n, at.towards), 0.0f));
    }
    return sum;
}

}  // namespace camrig::render::software
