#include "core/render/software/material_shading.h"

#include <array>

#include "core/render/software/contact_light.h"
#include "core/render/software/lambert.h"
#include "core/render/software/lanes_math.h"
#include "core/render/software/reflection_light.h"
#include "core/render/software/shading.h"
#include "core/render/software/shadow_lookup.h"
#include "core/render/software/tone_curve.h"
#include "core/render/surface_tables.h"

namespace camrig::render::software {
namespace {

/// The tables of the split sum, value by value.
struct SplitSum {
    std::array<float, table_side * table_side> scale{}, bias{}, sky{};
};
const SplitSum& split_sum() {
    static const SplitSum made = [] {
        SplitSum tables;
        const std::vector<glm::vec2> reflectance = make_reflectance_table();
        const std::vector<float> sky = make_sky_table();
        for (std::size_t i = 0; i < tables.scale.size(); ++i) {
            tables.scale[i] = reflectance[i].x;
            tables.bias[i] = reflectance[i].y;
            tables.sky[i] = sky[i];
        }
        return tables;
    }();
    return made;
}

/// Where a cosine and a roughness, both from 0 to 1, lie in a table.
struct TablePlace {
    IntLanes first;
    Lanes right, down;
};
CAMRIG_LANES TablePlace table_place(Lanes cosine, Lanes roughness) {
    constexpr float last = table_side - 1;
    const Lanes column = clamp01(cosine) * last, row = clamp01(roughness) * last;
    const Lanes left = min(floor(column), lanes(last - 1.0f)), upper = min(floor(row), lanes(last - 1.0f));
    return {truncated(upper) * table_side + truncated(left), column - left, row - upper};
}
template <typename Isa>
CAMRIG_LANES Lanes looked_up(const float* table, const TablePlace& at) {
    const auto of = [&](int offset) __attribute__((always_inline)) { return gathered<Isa>(table + offset, at.first); };
    const Lanes a = of(0), b = of(1), c = of(table_side), d = of(table_side + 1);
    const Lanes above = a + (b - a) * at.right, below = c + (d - c) * at.right;
    return above + (below - above) * at.down;
}

CAMRIG_LANES Lanes3 cross(const Lanes3& a, const Lanes3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
CAMRIG_LANES Lanes3 turned(const glm::mat3& m, const Lanes3& v) {
    return splat(m[0]) * v.x + splat(m[1]) * v.y + splat(m[2]) * v.z;
}
CAMRIG_LANES Lanes3 unit(const Lanes3& v) {
    return v * (1.0f / sqrt(max(dot(v, v), lanes(1e-30f))));
}
CAMRIG_LANES Lanes3 select(IntLanes mask, const Lanes3& yes, const Lanes3& no) {
    return {mask ? yes.x : no.x, mask ? yes.y : no.y, mask ? yes.z : no.z};
}

/// t along u, b against v (which points down in glTF), as MikkTSpace has it; from the file's tangents, or for each
/// triangle by itself.
template <typename Isa>
CAMRIG_LANES Lanes3 mapped_normal(const ViewDraw& draw, const SurfacePoints& points, const Lanes3& n) {
    const float scale = draw.primitive->material->normal_scale;
    const auto texture = sampled<Isa>(draw, normal_slot, TextureChannels::rgb, points);
    const Lanes x = (texture[0] * 2.0f - 1.0f) * scale, y = (texture[1] * 2.0f - 1.0f) * scale;
    const Lanes z = texture[2] * 2.0f - 1.0f;
    const glm::mat3 optical_from_local(glm::dmat3(draw.optical_from_local));
    Lanes3 t = turned(optical_from_local, points.tangent);
    t = t - n * dot(n, t);
    const IntLanes has_area = dot(t, t) > 0.0f;
    t = unit(t);
    Lanes3 b = cross(n, t);
    if (draw.tangents != nullptr) {
        // A mirroring turns the cross product of normal and tangent round, but not the bitangent.
        b = b * (draw.placed->is_mirrored ? -points.tangent_side : points.tangent_side);
    } else {
        const IntLanes is_along_v = dot(b, turned(optical_from_local, points.v_grows)) > 0.0f;
        b = select(is_along_v, b * lanes(-1.0f), b);
    }
    return select(has_area, unit(t * x + b * y + n * z), n);
}

CAMRIG_LANES Lanes mean(const Lanes3& v) {
    return (v.x + v.y + v.z) * (1.0f / 3.0f);
}

/// What a surface does to light.
struct SurfaceResponse {
    Lanes3 normal, view, diffuse, f0;
    Lanes3 gain;  ///< gives back what microfacets lose among each other (Turquin 2019)
    Lanes alpha, view_cosine;
    Lanes view_visibility;  ///< the view's factor of Smith's visibility term
};

/// Of one direction, whose cosine to the normal is given.
CAMRIG_LANES Lanes smith_visibility(Lanes cosine, Lanes a2) {
    return 1.0f / (cosine + sqrt(a2 + (1.0f - a2) * cosine * cosine));
}

/// Cook-Torrance with GGX, Smith's visibility and Schlick's Fresnel over a Lambert base, times pi because Lambert's
/// 1/pi is folded into the lights (glTF 2.0, appendix B). cosine: of the angle between normal and light,
/// where it is positive.
CAMRIG_LANES Lanes3 reflected(const SurfaceResponse& s, const Lanes3& towards, Lanes cosine) {
    const Lanes3 half = unit(s.view + towards);
    const Lanes nh = max(dot(s.normal, half), Lanes{}), vh = max(dot(s.view, half), Lanes{});
    const Lanes a2 = s.alpha * s.alpha;
    const Lanes d = nh * nh * (a2 - 1.0f) + 1.0f;
    const Lanes visibility = smith_visibility(max(cosine, Lanes{}), a2) * s.view_visibility;
    const Lanes away = 1.0f - vh, away2 = away * away;
    const Lanes3 one{lanes(1.0f), lanes(1.0f), lanes(1.0f)};
    const Lanes3 fresnel = s.f0 + (one - s.f0) * (away2 * away2 * away);
    return (s.diffuse * (one - fresnel) + fresnel * s.gain * (a2 / (d * d) * visibility)) * max(cosine, Lanes{});
}

/// Light from all around on a surface: from the map of baked light or a place of it, or of sky and ground.
template <typename Isa>
CAMRIG_LANES Lanes3 light_around(const ViewGeometry& geometry, const ViewDraw& draw, const SurfacePoints& points,
                                 const Lanes3& n) {
    if (draw.textures[light_slot] != nullptr) {
        const auto light = sampled<Isa>(draw, light_slot, TextureChannels::rgb, points);
        return Lanes3{light[0], light[1], light[2]} * splat(geometry.light_of_map());
    }
    if (draw.surroundings) {
        Lanes3 light = splat(draw.surroundings->mean) + turned(draw.surroundings->along, n);
        const std::array<Lanes, world::product_count> products = world::products_of(n);
        for (std::size_t i = 0; i < products.size(); ++i)
            light = light + splat(draw.surroundings->products[i]) * products[i];
        return {max(light.x, Lanes{}), max(light.y, Lanes{}), max(light.z, Lanes{})};
    }
    return hemisphere<PointGroup>(geometry.light(), n);
}

/// How much brighter a mirror image of the surroundings may be than what arrives; as in shaders/forward.frag.
constexpr float most_mirrored = 2.0f;

/// What of the surroundings is reflected, and how much of the light goes no further into the surface.
struct Mirror {
    Lanes3 share, light;
};

/// arriving: light from all around.
template <typename Isa>
CAMRIG_LANES Mirror mirrored(const ViewGeometry& geometry, SurfaceResponse& s, Lanes roughness, const Lanes3& position,
                             const Lanes3& arriving) {
    const SplitSum& tables = split_sum();
    const scene::AmbientInView& light = geometry.light();
    const TablePlace at = table_place(s.view_cosine, roughness);
    const Lanes scale = looked_up<Isa>(tables.scale.data(), at), bias = looked_up<Isa>(tables.bias.data(), at);
    const Lanes3 one{lanes(1.0f), lanes(1.0f), lanes(1.0f)};
    s.gain = one + s.f0 * (1.0f / (scale + bias) - 1.0f);
    const Lanes3 share = (s.f0 * scale + Lanes3{bias, bias, bias}) * s.gain;
    // The unclamped cosine: a view from below a bent normal is reflected like any other.
    const Lanes3 ray = s.normal * (2.0f * dot(s.normal, s.view)) - s.view;
    // Where images are to be seen in it, it is what is there.
    constexpr float roughest = world::reflection_levels[world::roughest_level].roughness, fading = 0.1f;
    const Lanes sharp = geometry.baked() == nullptr || geometry.reflections() == nullptr
                            ? Lanes{}
                            : clamp01((roughest - roughness) * (1.0f / fading));
    Lanes3 images{};
    if (Isa::bits(sharp > 0.0f) != 0)
        images = mirrored_light<Isa>(*geometry.reflections(), position,
                                     {s.normal, s.view, s.view_cosine, roughness, mean(s.f0)});
    if (Isa::bits(sharp < 1.0f) == 0) return {share, images};
    const Lanes height = dot(ray, splat(light.up));
    const Lanes sky = looked_up<Isa>(tables.sky.data(), table_place(0.5f + 0.5f * height, roughness));
    const Lanes3 around = splat(light.ground) + splat(light.sky - light.ground) * sky;
    Mirror mirror{share, {max(around.x, Lanes{}), max(around.y, Lanes{}), max(around.z, Lanes{})}};
    if (geometry.baked() == nullptr) return mirror;
    // As the mirror image is to the surface in the open, so it is here: but of what is dark in the open that has no
    // bound.
    const Lanes3 open = hemisphere<PointGroup>(light, s.normal);
    const auto part = [](Lanes of, Lanes all) __attribute__((always_inline)) {
        return all > 1e-6f ? min(of / max(all, lanes(1e-6f)), lanes(most_mirrored)) : lanes(1.0f);
    };
    mirror.light =
        arriving * Lanes3{part(mirror.light.x, open.x), part(mirror.light.y, open.y), part(mirror.light.z, open.z)};
    mirror.light = mirror.light * (1.0f - sharp) + images * sharp;
    return mirror;
}

/// Light that a surface sends by itself, which alpha does not thin, as a color to be blended by that alpha. What
/// outshines it hides more of what lies behind.
CAMRIG_LANES Rgba blended_over(const Lanes3& light, Lanes alpha) {
    const Lanes most = max(light.x, max(light.y, light.z));
    const Lanes a = clamp01(max(max(alpha, most), lanes(1e-3f)));
    return {light * (1.0f / a), a};
}

/// What of a light the surface sends on.
template <typename Isa>
CAMRIG_LANES void add_reflected(const SurfaceResponse& s, const ArrivingLight& arriving, const Lanes3& position,
                                const Lanes3& geometric, bool has_movers, Lanes3& sum) {
    const Lanes cosine = dot(s.normal, arriving.towards);
    if (Isa::bits(cosine > 0.0f) == 0) return;
    Lanes3 light = arriving.color * reflected(s, arriving.towards, cosine);
    if (!arriving.shadows.empty())
        light = light * lit_share<Isa>(arriving.shadows, has_movers, position, geometric, arriving.towards);
    const IntLanes is_before = cosine > 0.0f;
    sum = sum + select(is_before, light, Lanes3{});
}

template <typename Isa>
CAMRIG_LANES void shade_body(const ViewGeometry& geometry, const ViewDraw& draw, const SurfacePoints& points,
                             const Lanes3& rays, bool has_movers, Rgba& to) {
    const world::Material& material = *draw.primitive->material;
    const Rgba base = base_color<Isa>(draw, points);
    const float exposure = geometry.light().exposure;
    const Lanes3 position = rays * points.z;
    const Lanes3 geometric = unit(turned(draw.optical_from_normal, points.normal));
    SurfaceResponse s;
    s.normal = draw.textures[normal_slot] != nullptr ? mapped_normal<Isa>(draw, points, geometric) : geometric;
    Lanes metallic = lanes(material.metallic), roughness = lanes(material.roughness);
    if (draw.textures[metallic_roughness_slot] != nullptr) {
        const auto texture = sampled<Isa>(draw, metallic_roughness_slot, TextureChannels::rgb, points);
        roughness = roughness * texture[1];
        metallic = metallic * texture[2];
    }
    roughness = clamp01(roughness);
    s.view = unit(position) * lanes(-1.0f);
    s.view_cosine = clamp01(dot(s.normal, s.view));
    s.alpha = max(roughness * roughness, lanes(0.002f));
    s.view_visibility = smith_visibility(max(s.view_cosine, lanes(1e-4f)), s.alpha * s.alpha);
    s.diffuse = base.rgb * (1.0f - metallic);
    const bool is_glass = material.transmission > 0.0f;
    if (is_glass) s.diffuse = s.diffuse * base.a;
    const Lanes dielectric = dielectric_f0 * (1.0f - metallic);
    s.f0 = Lanes3{dielectric, dielectric, dielectric} + base.rgb * metallic;

    const Lanes3 around = light_around<Isa>(geometry, draw, points, s.normal);
    Mirror mirror = mirrored<Isa>(geometry, s, roughness, position, around);
    // A pane mirrors at both of its sides.
    if (is_glass) mirror.share = mirror.share * (2.0f / (1.0f + mean(mirror.share)));
    Lanes occlusion = lanes(1.0f);
    if (draw.textures[occlusion_slot] != nullptr) {
        const Lanes red = sampled<Isa>(draw, occlusion_slot, TextureChannels::red, points)[0];
        occlusion = 1.0f + material.occlusion_strength * (red - 1.0f);
        // Lagarde and de Rousiers, Moving Frostbite to physically based rendering, 2014: what hides the sky from a
        // surface hides it from its mirror image too, the more the rougher.
        const Lanes seen = max(s.view_cosine + occlusion, lanes(1e-9f));
        const Lanes power = exp2_of(exp2_of(-16.0f * roughness - 1.0f) * log2_of(seen));
        mirror.light = mirror.light * clamp01(power - 1.0f + occlusion);
    }
    Lanes3 sum = s.diffuse * around * (share_of_base(s.view_cosine) * occlusion) + mirror.share * mirror.light;
    if (geometry.bodies() != nullptr)
        sum = sum * open_share<Isa>(*geometry.bodies(), draw.placed->object->id, has_movers, position, geometric);
    // Lamps are in baked light.
    each_light(*draw.lights, geometry.baked() == nullptr, position,
               [&](const ArrivingLight& light) __attribute__((always_inline)) {
                   add_reflected<Isa>(s, light, position, geometric, has_movers, sum);
               });
    Lanes3 emissive = splat(material.emissive * exposure);
    if (draw.textures[emissive_slot] != nullptr) {
        const auto texture = sampled<Isa>(draw, emissive_slot, TextureChannels::rgb, points);
        emissive = emissive * Lanes3{texture[0], texture[1], texture[2]};
    }
    Rgba made{sum + emissive, base.a};
    if (geometry.has_tone_curve()) made.rgb = pbr_neutral(made.rgb);
    if (is_glass) {
        made = blended_over(made.rgb, 1.0f - (1.0f - base.a) * (1.0f - mean(mirror.share)));
        made.tint = splat(material.tint);
    }
    to = made;
}

template <typename Isa>
CAMRIG_LANES void arriving_body(const ViewGeometry& geometry, const ViewDraw& draw, const SurfacePoints& points,
                                const Lanes3& rays, bool has_movers, Lanes3& to) {
    const Lanes3 normal = unit(turned(draw.optical_from_normal, points.normal));
    const Lanes3 position = rays * points.z;
    to = light_around<Isa>(geometry, draw, points, normal);
    each_light(*draw.lights, geometry.baked() == nullptr, position,
               [&](const ArrivingLight& arriving) __attribute__((always_inline)) {
                   const Lanes cosine = max(dot(normal, arriving.towards), Lanes{});
                   if (Isa::bits(cosine > 0.0f) == 0) return;
                   Lanes3 light = arriving.color * cosine;
                   if (!arriving.shadows.empty())
                       light = light * lit_share<Isa>(arriving.shadows, has_movers, position, normal, arriving.towards);
                   to = to + light;
               });
}

}  // namespace

CAMRIG_WIDE void arriving_light_wide(const ViewGeometry& geometry, const ViewDraw& draw, const SurfacePoints& points,
                                     const Lanes3& rays, bool has_movers, Lanes3& to) {
    arriving_body<Avx2Isa>(geometry, draw, points, rays, has_movers, to);
}
void arriving_light_plain(const ViewGeometry& geometry, const ViewDraw& draw, const SurfacePoints& points,
                          const Lanes3& rays, bool has_movers, Lanes3& to) {
    arriving_body<PlainIsa>(geometry, draw, points, rays, has_movers, to);
}

CAMRIG_WIDE void shade_material_wide(const ViewGeometry& geometry, const ViewDraw& draw, const SurfacePoints& points,
                                     const Lanes3& rays, bool has_movers, Rgba& to) {
    shade_body<Avx2Isa>(geometry, draw, points, rays, has_movers, to);
}
void shade_material_plain(const ViewGeometry& geometry, const ViewDraw& draw, const SurfacePoints& points,
                          const Lanes3& rays, bool has_movers, Rgba& to) {
    shade_body<PlainIsa>(geometry, draw, points, rays, has_movers, to);
}

}  // namespace camrig::render::software
