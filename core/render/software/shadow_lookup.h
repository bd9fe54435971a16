#pragma once

#include <array>
#include <bit>
#include <cstring>
#include <span>

#include "core/render/software/lanes.h"
#include "core/render/software/shadow_view.h"

/// shaders/shadow.glsl for CPUs.
namespace camrig::render::software {

CAMRIG_LANES Lanes along(const glm::vec4& row, const Lanes3& p) {
    return p.x * row.x + p.y * row.y + p.z * row.z + row.w;
}

/// Where points lie in a map.
struct ShadowPlace {
    Lanes column, row, depth;
};
CAMRIG_LANES ShadowPlace shadow_place(const ShadowInView& map, const Lanes3& p) {
    const Lanes w = 1.0f / max(along(map.rows[3], p), lanes(1e-6f));
    return {along(map.rows[0], p) * w, along(map.rows[1], p) * w, along(map.rows[2], p) * w};
}

/// The texel right of and below the corner next to a place, moved to where the whole filter still lies in the map.
CAMRIG_LANES Lanes shadow_corner(Lanes at) {
    return min(max(floor(min(max(at + 0.5f, lanes(0.0f)), lanes(2.0f * shadow_stride))), lanes(shadow_pad - 2)),
               lanes(shadow_pad + shadow_map_side + 2));
}

/// At which tile the points are looked up.
CAMRIG_LANES IntLanes shadow_tile_of(Lanes column, Lanes row) {
    constexpr int shift = std::countr_zero(static_cast<unsigned>(shadow_tile));
    return (truncated(row) >> shift) * shadow_tiles + (truncated(column) >> shift);
}

/// Whether movers may be in the way of the light. Where the look-up leads, which depends on the normal, is not asked:
/// tiles are noted as far around movers as it can be away (reach_texels in shadow_plan.cpp).
template <typename Isa>
CAMRIG_LANES IntLanes may_show_movers(const ShadowInView& map, const Lanes3& position) {
    const ShadowPlace place = shadow_place(map, position);
    return gathered<Isa>(map.movers, shadow_tile_of(shadow_corner(place.column), shadow_corner(place.row))) != 0;
}

/// Share of the light that one map lets through to the points; all of it where they are not in it.
template <typename Isa>
CAMRIG_LANES Lanes share_in_map(const ShadowInView& map, bool has_movers, const Lanes3& position, const Lanes3& n,
                                Lanes cosine) {
    // A flat surface that leans away from the light by an angle a is as deep as its neighbour in the map where it is
    // moved by sin(a) texels along its normal; the filter reaches two texels.
    const Lanes side = map.texel_m + map.texel_per_m * max(along(map.rows[3], position), Lanes{});
    const Lanes lean = sqrt(max(1.0f - cosine * cosine, Lanes{}));
    const ShadowPlace place = shadow_place(map, position + n * (side * (0.5f + 2.0f * lean)));

    // The 3x3 tent that I. Castano (Shadow mapping summary, 2013) has in four bilinear fetches, texel by texel.
    const Lanes column = shadow_corner(place.column), row = shadow_corner(place.row);
    const Lanes s = clamp01(place.column + 0.5f - column), t = clamp01(place.row + 0.5f - row);
    const IntLanes tile = shadow_tile_of(column, row);
    const IntLanes of_movers = has_movers ? gathered<Isa>(map.movers, tile) : IntLanes{};

    // Most points lie where all texels around are nearer to the light than they are, or none.
    const Lanes least = gathered<Isa>(&map.bounds->least, tile * 2), most = gathered<Isa>(&map.bounds->most, tile * 2);
    const IntLanes is_lit = most <= place.depth, is_known = (is_lit | (least > place.depth)) & (of_movers == 0);
    const Lanes down = ((1.0f - t + (2.0f - t)) + (1.0f + t)) + t;
    Lanes sum = (down * (1.0f - s) + down * (2.0f - s)) + (down * (1.0f + s) + down * s);
    sum = is_lit ? sum : Lanes{};

    const IntLanes first =
        (truncated(row) - shadow_filter_before) * shadow_stride + truncated(column) - shadow_filter_before + of_movers;
    using Floats4 = float __attribute__((vector_size(16)));
    static_assert(shadow_filter_before + 1 + shadow_filter_behind == 4);
    for (unsigned left = Isa::bits(~is_known); left != 0; left &= left - 1) {
        const int k = std::countr_zero(left);
        const float* from = map.texels + first[k];
        const float depth = place.depth[k], below = t[k], right = s[k];
        const std::array<float, 4> weights{1.0f - below, 2.0f - below, 1.0f + below, below};
        Floats4 lit{};
        for (std::size_t r = 0; r < 4; ++r, from += shadow_stride) {
            Floats4 texels;
            std::memcpy(&texels, from, sizeof texels);
            lit += texels <= depth ? Floats4{} + weights[r] : Floats4{};
        }
        lit *= Floats4{1.0f - right, 2.0f - right, 1.0f + right, right};
        sum[k] = (lit[0] + lit[1]) + (lit[2] + lit[3]);
    }
    return sum * (1.0f / 16.0f);
}

/// Share of a light that reaches the points, whose surface has normal n, at an angle of that cosine to the light: what
/// its maps, of which there is at least one, let through.
template <typename Isa>
CAMRIG_LANES Lanes lit_share(std::span<const ShadowInView> maps, bool has_movers, const Lanes3& position,
                             const Lanes3& n, Lanes cosine) {
    if (maps.size() == 1) return share_in_map<Isa>(maps.front(), has_movers, position, n, cosine);
    // Sides of a cube overlap by more than a filter reaches: of two that see a point one is right, and the other lacks
    // at most what is before the point.
    Lanes least = lanes(1.0f);
    for (const ShadowInView& map : maps) {
        const ShadowPlace place = shadow_place(map, position);
        const IntLanes is_seen =
            (min(place.column, place.row) > 0.0f) & (max(place.column, place.row) < static_cast<float>(shadow_stride));
        if (Isa::bits(is_seen) == 0) continue;
        const Lanes share = share_in_map<Isa>(map, has_movers, position, n, cosine);
        least = is_seen ? min(least, share) : least;
    }
    return least;
}

}  // namespace camrig::render::software
