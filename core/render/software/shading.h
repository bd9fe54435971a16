#pragma once

#include <numbers>
#include <type_traits>

#include "core/render/software/lambert.h"
#include "core/render/software/lanes_math.h"
#include "core/render/software/material_shading.h"
#include "core/render/software/surface_point.h"

/// The colour of the points of a surface that a group of pixels shows: core/render/shaders for the CPU.
namespace camrig::render::software {

template <typename Isa>
CAMRIG_LANES SampledLanes sampled(const ViewDraw& draw, TextureSlot slot, TextureChannels channels,
                                  const SurfacePoints& points) {
    SampledLanes made;
    const auto sample = std::is_same_v<Isa, Avx2Isa> ? sample_wide : sample_plain;
    sample(*draw.textures[slot], points.textures[slot], channels,
           draw.primitive->material->alpha_mode == world::AlphaMode::opaque, made);
    return made;
}

template <typename Isa>
CAMRIG_LANES Rgba base_color(const ViewDraw& draw, const SurfacePoints& points) {
    const glm::vec4& factor = draw.base_color;
    Rgba base{{lanes(factor.r), lanes(factor.g), lanes(factor.b)}, lanes(factor.a)};
    if (draw.colors != nullptr) {
        base.rgb = base.rgb * Lanes3{points.color[0], points.color[1], points.color[2]};
        base.a = base.a * points.color[3];
    }
    if (draw.textures[base_color_slot] != nullptr) {
        const auto texture = sampled<Isa>(draw, base_color_slot, TextureChannels::rgba, points);
        base.rgb = base.rgb * Lanes3{texture[0], texture[1], texture[2]};
        base.a = base.a * texture[3];
    }
    return base;
}

/// Its alpha alone.
template <typename Isa>
CAMRIG_LANES Lanes base_alpha(const ViewDraw& draw, const SurfacePoints& points) {
    Lanes alpha = lanes(draw.base_color.a);
    if (draw.colors != nullptr) alpha = alpha * points.color[3];
    if (draw.textures[base_color_slot] != nullptr)
        alpha = alpha * sampled<Isa>(draw, base_color_slot, TextureChannels::alpha, points)[3];
    return alpha;
}

CAMRIG_LANES Lanes3 splat(const glm::vec3& v) {
    return PointGroup::vector(v);
}

/// Where the rays through a group of pixels meet the plane one metre in front of the eye, or LensRays.
CAMRIG_LANES Lanes3 rays_through(const ViewGeometry& geometry, int x, int y) {
    if (geometry.rays() != nullptr) return rays_at(*geometry.rays(), x, y);
    const camera::Intrinsics& k = geometry.transform().intrinsics;
    return {(lane_numbers() + static_cast<float>(x - k.cx)) * static_cast<float>(1.0 / k.fx),
            lanes(static_cast<float>(y - k.cy) * static_cast<float>(1.0 / k.fy)), lanes(1.0f)};
}

template <typename Isa>
CAMRIG_LANES Lanes3 rays_through(const ViewGeometry& geometry, const PixelLanes& pixels) {
    if (geometry.rays() != nullptr) return pixels.rays<Isa>(*geometry.rays(), 0, 0);
    const camera::Intrinsics& k = geometry.transform().intrinsics;
    const Lanes lane = __builtin_convertvector(pixels.lane, Lanes);
    return {(lane + narrowed(widened(pixels.first) + -k.cx)) * static_cast<float>(1.0 / k.fx),
            narrowed(widened(pixels.y) + -k.cy) * static_cast<float>(1.0 / k.fy), lanes(1.0f)};
}

CAMRIG_LANES Lanes3 surface_light(const ViewGeometry& geometry, const ViewDraw& draw, const SurfacePoints& points,
                                  const Lanes3& rays, Lanes occlusion) {
    if (draw.vertex_lights >= 0) {
        return points.light + points.ambient * (occlusion - 1.0f);
    }
    const glm::mat3& m = draw.optical_from_normal;
    Lanes3 n = splat(m[0]) * points.normal.x + splat(m[1]) * points.normal.y + splat(m[2]) * points.normal.z;
    n = n * (1.0f / sqrt(max(dot(n, n), lanes(1e-30f))));
    const Lanes3 position = rays * points.z;
    return hemisphere<PointGroup>(geometry.light(), n) * occlusion + lambert<PointGroup>(*draw.lights, n, position);
}

/// x^(1/2.4) fitted by two square roots, as srgb.glsl: at most 0.03 of a code of 255 from IEC 61966-2-1.
CAMRIG_LANES Lanes srgb(Lanes c) {
    c = clamp01(c);
    const Lanes root = sqrt(c);
    const Lanes high =
        0.91269030f * root + 0.25450221f * sqrt(root) + c * (0.03564411f * root - 0.13222371f) - 0.07051239f;
    return c <= 0.0031308f ? 12.92f * c : high;
}

CAMRIG_LANES IntLanes code(Lanes value) {
    return truncated(value * 255.0f + 0.5f);
}

/// As shade(), without fog.
template <typename Isa>
CAMRIG_LANES Rgba shade_surface(const ViewGeometry& geometry, const ViewDraw& draw, const SurfacePoints& points,
                                const Lanes3& rays, bool has_movers) {
    const world::Material& material = *draw.primitive->material;
    if (geometry.is_beautiful() && draw.primitive->is_lit) {
        Rgba made;
        const auto shade_material = std::is_same_v<Isa, Avx2Isa> ? shade_material_wide : shade_material_plain;
        shade_material(geometry, draw, points, rays, has_movers, made);
        return made;
    }
    const Rgba color = base_color<Isa>(draw, points);
    const float exposure = geometry.light().exposure;
    if (!draw.primitive->is_lit) return {color.rgb * lanes(exposure), color.a};
    Lanes occlusion = lanes(1.0f);
    if (draw.textures[occlusion_slot] != nullptr) {
        const Lanes red = sampled<Isa>(draw, occlusion_slot, TextureChannels::red, points)[0];
        occlusion = 1.0f + material.occlusion_strength * (red - 1.0f);
    }
    Lanes3 emissive = splat(material.emissive * exposure);
    if (draw.textures[emissive_slot] != nullptr) {
        const auto texture = sampled<Isa>(draw, emissive_slot, TextureChannels::rgb, points);
        emissive = emissive * Lanes3{texture[0], texture[1], texture[2]};
    }
    return {color.rgb * surface_light(geometry, draw, points, rays, occlusion) + emissive, color.a};
}

/// Linear light of a group of points. has_movers: at quality beautiful, in the shadows of what moves, too.
template <typename Isa>
CAMRIG_LANES Rgba shade(const ViewGeometry& geometry, const ViewDraw& draw, const SurfacePoints& points,
                        const Lanes3& rays, bool has_movers = true) {
    Rgba made = shade_surface<Isa>(geometry, draw, points, rays, has_movers);
    const scene::FogInView& fog = geometry.fog();
    if (fog.per_m > 0.0f) {
        constexpr float least_power = -100.0f;
        const Lanes distance = sqrt(dot(rays, rays)) * max(points.z, -points.z);
        const Lanes left = exp2_of(max(distance * (-fog.per_m * std::numbers::log2e_v<float>), lanes(least_power)));
        made.rgb = splat(fog.color) + (made.rgb - splat(fog.color)) * left;
    }
    return made;
}

CAMRIG_LANES IntLanes pixels_of(const Lanes3& srgb_color) {
    return code(srgb_color.x) | (code(srgb_color.y) << 8) | (code(srgb_color.z) << 16) | (IntLanes{} + (255 << 24));
}

CAMRIG_LANES void store(const LightRows& rows, int x, int y, IntLanes mask, const Lanes3& light) {
    const auto put = [&](const Rows<float>& row, Lanes value) __attribute__((always_inline)) {
        auto* const kept = reinterpret_cast<Lanes*>(row(y) + x);
        *kept = mask ? value : *kept;
    };
    put(rows.red, light.x);
    put(rows.green, light.y);
    put(rows.blue, light.z);
}
CAMRIG_LANES Lanes3 light_at(const LightRows& rows, int x, int y) {
    const auto at = [&](const Rows<float>& row)
                        __attribute__((always_inline)) { return *reinterpret_cast<const Lanes*>(row(y) + x); };
    return {at(rows.red), at(rows.green), at(rows.blue)};
}

CAMRIG_LANES void store(std::uint32_t* row, int x, IntLanes mask, IntLanes values) {
    store_lanes(row + x, mask ? values : load_lanes(row + x));
}

}  // namespace camrig::render::software
