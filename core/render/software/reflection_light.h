#pragma once

#include "core/render/scene/reflections.h"
#include "core/render/software/lambert.h"
#include "core/render/software/lanes.h"

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

template <typename Isa>
CAMRIG_LANES Lanes3 level_light(const scene::ReflectionMaps& maps, IntLanes probe, IntLanes level,
                                const Lanes3& direction) {
    static_assert(world::reflection_levels[3].side == world::reflection_levels[0].side >> 3);
    const IntLanes sides = (IntLanes{} + world::reflection_levels[0].side) >> level;
    SquarePlace at = square_place(direction, __builtin_convertvector(sides, Lanes));
    at.first += probe * scene::ReflectionMaps::level_starts.back() +
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
CAMRIG_LANES SeenPlace seen_from(const scene::ReflectionMaps& maps, IntLanes probe, const Lanes3& from_probe,
                                 const Lanes3& ray) {
    constexpr int steps = 2;
    constexpr float least_m = 1e-3f, least_nearness = 1e-5f;
    const Lanes sides = lanes(world::nearness_side);
    Lanes3 direction = ray;
    Lanes farther = lanes(1.0f);
    for (int i = 0; i < steps; ++i) {
        SquarePlace at = square_place(direction, sides);
        at.first += probe * scene::bordered_texels(world::nearness_side);
        const Lanes nearness = between_texels(
            at, IntLanes{} + scene::bordered_side(world::nearness_side),
            [&](IntLanes index) __attribute__((always_inline)) { return gathered<Isa>(maps.nearness.data(), index); });
        const Lanes distance = 1.0f / max(nearness, lanes(least_nearness)) - 1.0f;
        const Lanes length = max(dot(direction * distance - from_probe, ray), lanes(least_m));
        direction = from_probe + ray * length;
        const Lanes inverse = 1.0f / sqrt(max(dot(direction, direction), lanes(1e-30f)));
        direction = direction * inverse;
        farther = length * inverse;
    }
    return {direction, farther};
}

/// Light that comes along a ray from the surroundings of places, both in the optical frame, as a surface of that
/// roughness spreads it: from the two nearest probes.
template <typename Isa>
CAMRIG_LANES Lanes3 light_along(const scene::ReflectionsInView& view, const Lanes3& position, const Lanes3& ray,
                                Lanes roughness) {
    const auto [xs, ys, zs] = std::array{view.places[0].data(), view.places[1].data(), view.places[2].data()};
    Lanes first2 = lanes(1e30f), second2 = lanes(1e30f);
    IntLanes first{}, second{};
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(view.places[0].size()); ++i) {
        const Lanes3 away{position.x - xs[i], position.y - ys[i], position.z - zs[i]};
        const Lanes distance2 = dot(away, away);
        const IntLanes is_first = distance2 < first2, is_second = distance2 < second2;
        second = is_first ? first : is_second ? IntLanes{} + i : second;
        second2 = is_first ? first2 : is_second ? distance2 : second2;
        first = is_first ? IntLanes{} + i : first;
        first2 = is_first ? distance2 : first2;
    }
    // Half of each where they are equally far, and no more of the second where it is a third further away.
    constexpr float alone = 0.5625f;
    const Lanes nearly = clamp01((first2 / second2 - alone) * (1.0f / (1.0f - alone)));
    const Lanes share = nearly * nearly * (1.5f - nearly);

    const glm::mat3& turn = view.world_from_optical;
    const auto in_world = [&](const Lanes3& v) __attribute__((always_inline)) {
        return PointGroup::vector(turn[0]) * v.x + PointGroup::vector(turn[1]) * v.y +
               PointGroup::vector(turn[2]) * v.z;
    };
    const Lanes3 along = in_world(ray);
    constexpr auto last = static_cast<float>(world::reflection_levels.size() - 1);
    const auto of = [&](IntLanes probe) __attribute__((always_inline)) {
        const Lanes3 from_probe =
            in_world({position.x - gathered<Isa>(xs, probe), position.y - gathered<Isa>(ys, probe),
                      position.z - gathered<Isa>(zs, probe)});
        const SeenPlace seen = seen_from<Isa>(*view.maps, probe, from_probe, along);
        // What is near is spread over less of itself than the probe, which is farther away, has it (Lagarde and de
        // Rousiers, Moving Frostbite to physically based rendering, 2014).
        const Lanes at = min(roughness * seen.farther * (1.0f / world::roughness_of_level), lanes(last));
        const Lanes level = min(floor(at), lanes(last - 1.0f)), rougher = at - level;
        return level_light<Isa>(*view.maps, probe, truncated(level), seen.direction) * (1.0f - rougher) +
               level_light<Isa>(*view.maps, probe, truncated(level) + 1, seen.direction) * rougher;
    };
    Lanes3 light = of(first);
    if (Isa::bits(share > 0.0f) != 0) light = light * (1.0f - share) + of(second) * share;
    return light * PointGroup::vector(view.gain);
}

}  // namespace camrig::render::software
