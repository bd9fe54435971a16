#include "core/render/gl/pass_uniforms.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <type_traits>

#include "core/base/result.h"
#include "core/render/scene/view_lights.h"

namespace camrig::render::gl {
namespace {

glm::vec4 row(const glm::dmat3& m, int i, double w = 0.0) {
    return glm::vec4(glm::dvec4(m[0][i], m[1][i], m[2][i], w));
}

template <typename T>
void put(std::byte*& to, const T& value) {
    std::memcpy(to, &value, sizeof(T));
    to += sizeof(T);
}

}  // namespace

ViewBlock view_block(const PassView& view) {
    const ViewTransform& t = view.transform;
    const scene::AmbientInView ambient = scene::ambient_in_view(view.scene->environment(), view.exposure(), t);
    const scene::FogInView fog = view.fog();
    ViewBlock block{};
    block.projection = glm::vec4(glm::dvec4(t.x_scale, t.x_shift, t.y_scale, t.y_shift));
    block.depth = glm::vec4(glm::dvec4(t.depth_scale, t.depth_shift, 0.0, 0.0));
    block.up = glm::vec4(ambient.up, 0.0f);
    block.sky = glm::vec4(ambient.sky, ambient.exposure);
    block.ground = glm::vec4(ambient.ground, view.scene->environment().daylight ? 1.0f : 0.0f);
    block.fog = glm::vec4(fog.color, fog.per_m);
    block.bodies.x = static_cast<float>(view.bodies == nullptr ? 0 : view.bodies->bodies.size());
    if (view.light_map != nullptr) {
        const ImageSize size = view.light_map->size();
        block.light_map = glm::vec4(view.light_map->scale() * view.exposure_gain, 1.0f / static_cast<float>(size.width),
                                    1.0f / static_cast<float>(size.height), 0.0f);
    }
    for (int i = 0; i < 3; ++i) block.truth_rows[i] = row(t.truth_from_optical, i);
    return block;
}

DrawBlock draw_block(const scene::SeenSurface& seen) {
    const glm::dmat4& optical_from_local = seen.optical_from_local;
    const glm::dmat3 m(optical_from_local);
    const glm::dmat3 normals = scene::normals_from(optical_from_local, seen.placed->is_mirrored);
    DrawBlock block{};
    for (int i = 0; i < 3; ++i) {
        block.position_rows[i] = row(m, i, optical_from_local[3][i]);
        block.normal_rows[i] = row(normals, i);
    }
    block.ids = glm::uvec4(static_cast<std::uint32_t>(seen.placed->object->id),
                           glm::uvec2(seen.placed->light_map_at.value_or(glm::ivec2(0))), 0u);
    block.tint = glm::vec4(seen.placed->tint, 1.0f);
    return block;
}

SurroundingsBlock surroundings_block(const PassView& view, const scene::PlacedSurface& surface) {
    const world::LightProbe probe = view.light_map->around(surface, view.scene->environment());
    const world::LightProbe light =
        scene::surroundings_in_view(probe.scaled(glm::vec3(view.exposure_gain)), view.transform);
    SurroundingsBlock block{};
    for (int i = 0; i < 3; ++i)
        block.rows[i] = glm::vec4(light.along[0][i], light.along[1][i], light.along[2][i], light.mean[i]);
    static_assert(std::extent_v<decltype(block.products)> == world::product_count);
    for (std::size_t i = 0; i < world::product_count; ++i) block.products[i] = glm::vec4(light.products[i], 0.0f);
    return block;
}

ReflectionBlock reflection_block(const PassView& view) {
    const ViewTransform& t = view.transform;
    const std::span<const glm::vec3> places = view.light_map->reflection_places();
    ReflectionBlock block{};
    CHECK(places.size() <= std::size(block.places));
    // The columns of its inverse, which is its transpose.
    for (int i = 0; i < 3; ++i) block.world_rows[i] = glm::vec4(glm::vec3(t.optical_from_world[i]), 0.0f);
    block.gain = glm::vec4(glm::vec3(view.exposure_gain), static_cast<float>(places.size()));
    for (std::size_t i = 0; i < places.size(); ++i)
        block.places[i] = glm::vec4(glm::vec3(t.optical_from_world * (glm::dvec3(places[i]) - t.eye)), 0.0f);
    return block;
}

scene::LightSet lights_of(const PassView& view, const scene::PlacedSurface& surface) {
    scene::LightSet set = view.scene->light_sets()[surface.light_set];
    if (view.light_map != nullptr) set.local = 0;
    return set;
}

LightAround light_around(const PassView& view, const scene::PlacedSurface& surface) {
    if (view.light_map == nullptr || !surface.primitive->is_lit) return LightAround::hemisphere;
    return surface.light_map_at ? LightAround::map : LightAround::surroundings;
}

DrawBlock shadow_draw_block(const glm::dmat4& clip_from_local) {
    const glm::dmat4 rows = glm::transpose(clip_from_local);
    DrawBlock block{};
    for (int i = 0; i < 3; ++i) block.position_rows[i] = glm::vec4(rows[i]);
    block.normal_rows[0] = glm::vec4(rows[3]);
    return block;
}

ShadowBlock shadow_block(const PassView& view) {
    // Texture places run from 0 to 1.
    const glm::dmat4 place_from_clip(glm::dvec4(0.5, 0, 0, 0), glm::dvec4(0, 0.5, 0, 0), glm::dvec4(0, 0, 1, 0),
                                     glm::dvec4(0.5, 0.5, 0, 1));
    const ViewTransform& t = view.transform;
    ShadowBlock block{};
    for (std::size_t i = 0; i < view.shadows.size(); ++i) {
        const ShadowView& shadow = view.shadows[i];
        glm::dmat4 map_from_optical(shadow.map_from_world * glm::transpose(t.optical_from_world));
        map_from_optical[3] = glm::dvec4(shadow.map_from_world * (t.eye - shadow.origin), 1.0);
        const glm::dmat4 rows = glm::transpose(place_from_clip * shadow.clip_from_map * map_from_optical);
        for (int r = 0; r < 4; ++r) block.maps[i].rows[r] = glm::vec4(rows[r]);
        std::ranges::copy(plane_rows({rows[0], rows[1], rows[2], rows[3]}), block.maps[i].planes);
        block.maps[i].texel = glm::vec4(glm::dvec4(shadow.texel_m, shadow.texel_per_m, 0.0, 0.0));
    }
    return block;
}

std::span<const ShadowView> shadow_maps_of(const PassView& view, std::size_t light) {
    const auto first = std::ranges::find(view.shadows, light, &ShadowView::light);
    return {first, std::find_if(first, view.shadows.end(), [&](const auto& shadow) { return shadow.light != light; })};
}

std::size_t light_bytes(const PassView& view, const scene::LightSet& set) {
    const auto directional = static_cast<std::size_t>(rounded_directional(set.directional));
    const auto local = static_cast<std::size_t>(rounded_local(set.local));
    const std::size_t slots = view.shadows.empty() ? 0 : directional + local;
    return directional * sizeof(DirectionalLightBlock) + local * sizeof(LocalLightBlock) +
           slots * sizeof(ShadowSlotBlock);
}

void write_lights(const PassView& view, const scene::LightSet& set, std::byte* to) {
    const auto in_view = [&](int i) {
        const world::Light& light = view.scene->lights()[set.lights[static_cast<std::size_t>(i)]];
        return scene::light_in_view(light, view.transform, view.exposure());
    };
    const int directional = rounded_directional(set.directional);
    const int local = rounded_local(set.local);
    for (int i = 0; i < directional; ++i) {
        DirectionalLightBlock block{};
        if (i < set.directional) {
            const scene::LightInView light = in_view(i);
            block = {glm::vec4(light.towards, 0.0f), glm::vec4(light.color, 0.0f)};
        }
        put(to, block);
    }
    for (int i = 0; i < local; ++i) {
        LocalLightBlock block{glm::vec4(0.0f, 0.0f, -1.0f, 0.0f), glm::vec4(0.0f), glm::vec4(0.0f)};
        if (i < set.local) {
            const scene::LightInView light = in_view(set.directional + i);
            block = {glm::vec4(light.position, light.inverse_range2), glm::vec4(light.color, light.spot_scale),
                     glm::vec4(light.direction, light.spot_offset)};
        }
        put(to, block);
    }
    if (view.shadows.empty()) return;
    for (int i = 0; i < directional + local; ++i) {
        const int n = i < directional ? i : set.directional + i - directional;
        const bool is_used = i < directional ? i < set.directional : i - directional < set.local;
        ShadowSlotBlock block{};
        if (is_used) {
            const auto maps = shadow_maps_of(view, set.lights[n]);
            block.maps.x = static_cast<float>(maps.data() - view.shadows.data());
            block.maps.y = static_cast<float>(maps.size());
        }
        put(to, block);
    }
}

}  // namespace camrig::render::gl
