#pragma once

#include <array>

#include "core/render/scene/reflections.h"
#include "core/render/software/lambert.h"
#include "core/render/software/lanes.h"
#include "core/render/software/nearest_probes.h"

/// What reflection probes say of the light that comes along a mirrored ray.
namespace camrig::render::software {

/// Texels of squares with borders: where four lie around a point, and what share the right and lower ones have.
struct SquarePlace {
    IntLanes first;
    Lanes right, down;
};
/// world::octahedral_place() of directions that need no length; sides: of the squares, without their borders.
CAMRIG_LANES SquarePlace square_place(const Lanes3& direction, Lanes sides) {
    const auto magnitude = [](Lanes v) __attribute__((always_inline)) { return max(v, -v); };
    const Lanes inverse =
        1.0f / max(magnitude(direction.x) + magnitude(direction.y) + magnitude(direction.z), lanes(1e-30f));
    const Lanes x = direction.x * inverse, y = direction.y * inverse;
    const auto signed_as = [](Lanes value, Lanes sign)
                               __attribute__((always_inline)) { return sign < 0.0f ? -value : value; };
    const IntLanes is_below = direction.z < 0.0f;
    const Lanes u = is_below ? signed_as(1.0f - magnitude(y), x) : x;
    const Lanes v = is_below ? signed_as(1.0f - magnitude(x), y) : y;
    const Lanes column = clamp01(0.5f + 0.5f * u) * sides + 0.5f, row = clamp01(0.5f + 0.5f * v) * sides + 0.5f;
    const Lanes left = floor(column), upper = floor(row);
    return {truncated(upper) * (truncated(sides) + 2) + truncated(left), column - left, row - upper};
}

/// world::unpacked_light().
CAMRIG_LANES Lanes3 unpacked(IntLanes words) {
    const Lanes scale = reinterpret_cast<Lanes>((((words >> 27) & 31) + (127 - 24)) << 23);
    const auto channel = [&](int shift) __attribute__((always_inline)) {
        return __builtin_convertvector((words >> shift) & 511, Lanes) * scale;
    };
    return {channel(0), channel(9), channel(18)};
}

/// value: of an index into the squares, a number or a vector.
template <typename Value>
CAMRIG_LANES auto between_texels(const SquarePlace& at, IntLanes row, const Value& value) {
    const auto upper = value(at.first) * (1.0f - at.right) + value(at.first + 1) * at.right;
    const auto lower = value(at.first + row) * (1.0f - at.right) + value(at.first + row + 1) * at.right;
    return upper * (1.0f - at.down) + lower * at.down;
}

/// Numbers of world::reflection_levels that a place lies between, and how much of the second it has.
struct LevelsBetween {
    IntLanes lower, upper;
    Lanes part;
};
/// roughness: of the surface, which says whether it is a mirror; spread: as rough as what it mirrors looks.
CAMRIG_LANES LevelsBetween levels_between(Lanes roughness, Lanes spread) {
    constexpr auto& levels = world::reflection_levels;
    static_assert(levels.size() == 4);
    constexpr float first = levels[0].roughness, second = levels[1].roughness, third = levels[2].roughness;
    const IntLanes is_mirror = roughness < first;
    const Lanes at = max(min((spread - first) * (1.0f / (second - first)),
                             min((spread - second) * (1.0f / (third - second)) + 1.0f, lanes(2.0f))),
                         Lanes{});
    const IntLanes lower = at >= 1.0f ? IntLanes{} + 1 : IntLanes{};
    LevelsBetween made;
    made.lower = is_mirror ? IntLanes{} + static_cast<std::int32_t>(world::mirror_level) : lower;
    made.upper = is_mirror ? IntLanes{} : lower + 1;
    made.part = is_mirror ? clamp01(spread * (1.0f / first)) : at - __builtin_convertvector(lower, Lanes);
    return made;
}

template <typename Isa>
CAMRIG_LANES Lanes3 level_light(const scene::ReflectionMaps& maps, IntLanes probe, IntLanes level,
                                const Lanes3& direction) {
    constexpr auto& levels = world::reflection_levels;
    constexpr auto mirror = static_cast<std::int32_t>(world::mirror_level);
    static_assert(levels[world::roughest_level].side == levels[0].side >> world::roughest_level);
    const IntLanes sides =
        level == mirror ? IntLanes{} + levels[world::mirror_level].side : (IntLanes{} + levels[0].side) >> level;
    SquarePlace at = square_place(direction, __builtin_convertvector(sides, Lanes));
    constexpr auto most = static_cast<std::int32_t>(world::most_mirror_probes);
    at.first += probe * scene::ReflectionMaps::level_starts[world::mirror_level] +
                (probe < most ? probe : IntLanes{} + most) * scene::ReflectionMaps::texels_of_mirror +
                gathered<Isa>(scene::ReflectionMaps::level_starts.data(), level);
    const auto* const words = reinterpret_cast<const std::int32_t*>(maps.texels.data());
    return between_texels(at, sides + 2, [&](IntLanes index) __attribute__((always_inline)) {
        return unpacked(gathered<Isa>(words, index));
    });
}

/// Which way a probe sees what a ray meets, and how much farther that is from where the ray begins than from the probe.
struct SeenPlace {
    Lanes3 direction;
    Lanes farther;
};
/// The probe stands elsewhere: its distances say where the ray ends.
template <typename Isa>
CAMRIG_LANES SeenPlace seen_from(const scene::ProbeSights& sights, IntLanes probe, const Lanes3& from_probe,
                                 const Lanes3& ray) {
    constexpr int steps = 2;
    constexpr float least_m = 1e-3f, least_nearness = 1e-5f;
    const Lanes sides = lanes(world::nearness_side);
    Lanes3 direction = ray;
    Lanes farther = lanes(1.0f);
    for (int i = 0; i < steps; ++i) {
        SquarePlace at = square_place(direction, sides);
        at.first += probe * scene::bordered_texels(world::nearness_side);
        const Lanes nearness = between_texels(at, IntLanes{} + scene::bordered_side(world::nearness_side),
                                              [&](IntLanes index) __attribute__((always_inline)) {
                                                  return gathered<Isa>(sights.nearness.data(), index);
                                              });
        const Lanes distance = 1.0f / max(nearness, lanes(least_nearness)) - 1.0f;
        const Lanes length = max(dot(direction * distance - from_probe, ray), lanes(least_m));
        direction = from_probe + ray * length;
        const Lanes inverse = 1.0f / sqrt(max(dot(direction, direction), lanes(1e-30f)));
        direction = direction * inverse;
        farther = length * inverse;
    }
    return {direction, farther};
}

/// A surface that mirrors.
struct Mirroring {
    Lanes3 normal, view;  ///< unit, in the optical frame; view: towards who looks
    Lanes cosine;         ///< of the angle between them, from 0 to 1
    Lanes roughness, f0;
};

/// Light that a surface mirrors, in the optical frame, from the two nearest probes. A probe's image is spread evenly
/// about each direction; seen aslant, a rough surface spreads what it mirrors no wider across than the cosine leaves of
/// it, and all the wider up and down. So the image is as sharp as that, and looked at in three directions, which halves
/// turned towards and away from who looks mirror; each counts as microfacets there do (Walter et al., Microfacet models
/// for refraction through rough surfaces, 2007).
template <typename Isa>
CAMRIG_LANES Lanes3 mirrored_light(const scene::ReflectionsInView& view, const Lanes3& position, const Mirroring& of) {
    const glm::mat3& turn = view.world_from_optical;
    const auto in_world = [&](const Lanes3& v) __attribute__((always_inline)) {
        return PointGroup::vector(turn[0]) * v.x + PointGroup::vector(turn[1]) * v.y +
               PointGroup::vector(turn[2]) * v.z;
    };
    const scene::ProbeCells& cells = view.sights->cells;
    const Lanes3 place = in_world(position) + PointGroup::vector(view.eye);
    const IntLanes is_mirror = of.roughness < world::reflection_levels[0].roughness;
    const NearestProbes probes = nearest_probes<Isa>(cells, place, is_mirror);

    // In the plane of view and normal, x towards who looks.
    constexpr float least_cosine = 0.02f;
    const Lanes alpha = of.roughness * of.roughness, alpha2 = alpha * alpha;
    const Lanes z = max(of.cosine, lanes(least_cosine)), x = sqrt(max(1.0f - z * z, Lanes{}));
    const Lanes3 aside = of.view - of.normal * dot(of.normal, of.view);
    const Lanes3 axis = aside * (1.0f / sqrt(max(dot(aside, aside), lanes(1e-12f))));
    const auto masking = [&](Lanes cosine) __attribute__((always_inline)) {
        const Lanes cosine2 = cosine * cosine;
        return 0.5f * sqrt(1.0f + alpha2 * (1.0f - cosine2) / cosine2);  // Smith's, and a half
    };
    // Parts of alpha; where pictures are nearest to the whole lobe.
    constexpr std::array<float, 3> halves{0.0f, 0.76f, -0.76f};
    const int looks = Isa::bits(~is_mirror) == 0 ? 1 : 3;
    std::array<Lanes3, 3> ways;
    std::array<Lanes, 3> weights;
    Lanes sum{};
    const Lanes masked = masking(z);
    for (std::size_t i = 0; i < static_cast<std::size_t>(looks); ++i) {
        const Lanes turned = alpha * x * halves[i], half_z = 1.0f / sqrt(1.0f + turned * turned),
                    half_x = turned * half_z;
        const Lanes cosine = x * half_x + z * half_z;
        const Lanes way_x = 2.0f * cosine * half_x - x, way_z = 2.0f * cosine * half_z - z;
        const Lanes away = 1.0f - clamp01(cosine), away2 = away * away;
        const Lanes fresnel = of.f0 + (1.0f - of.f0) * (away2 * away2 * away);
        const Lanes weight = fresnel * cosine / (masked + masking(max(way_z, lanes(least_cosine))));
        weights[i] = (cosine > 0.0f) & (way_z > 0.0f) ? weight : Lanes{};
        sum += weights[i];
        ways[i] = in_world(axis * way_x + of.normal * max(way_z, lanes(least_cosine)));
    }
    const Lanes inverse = 1.0f / max(sum, lanes(1e-9f));
    for (std::size_t i = 0; i < static_cast<std::size_t>(looks); ++i) weights[i] = weights[i] * inverse;

    const Lanes across = sqrt(alpha * z);  // as roughness
    const auto seen_by = [&](IntLanes probe) __attribute__((always_inline)) {
        const auto along = [&](std::size_t i, Lanes from) __attribute__((always_inline)) {
            return from - gathered<Isa>(cells.places()[i].data(), probe);
        };
        const SeenPlace seen =
            seen_from<Isa>(*view.sights, probe, {along(0, place.x), along(1, place.y), along(2, place.z)}, ways[0]);
        // What is near is spread over less of itself than the probe, which is farther away, has it (Lagarde and de
        // Rousiers, Moving Frostbite to physically based rendering, 2014).
        const LevelsBetween levels = levels_between(of.roughness, across * seen.farther);
        Lanes3 light{};
        for (std::size_t i = 0; i < static_cast<std::size_t>(looks); ++i) {
            const Lanes3 way = seen.direction + (ways[i] - ways[0]) * seen.farther;
            light = light + (level_light<Isa>(*view.maps, probe, levels.lower, way) * (1.0f - levels.part) +
                             level_light<Isa>(*view.maps, probe, levels.upper, way) * levels.part) *
                                weights[i];
        }
        return light;
    };
    Lanes3 light = seen_by(probes.first);
    if (Isa::bits(probes.share > 0.0f) != 0)
        light = light * (1.0f - probes.share) + seen_by(probes.second) * probes.share;
    return light * PointGroup::vector(view.gain);
}

}  // namespace camrig::render::software
