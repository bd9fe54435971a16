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
CAMRIG_LANES Lanes shadow_corner(const ShadowInView& map, Lanes at) {
    const auto last = static_cast<float>(shadow_pad + map.side + 2);
    return min(max(floor(min(max(at + 0.5f, lanes(0.0f)), lanes(2.0f * last))), lanes(shadow_pad - 2)), lanes(last));
}

/// At which tile the points are looked up.
CAMRIG_LANES IntLanes shadow_tile_of(const ShadowInView& map, Lanes column, Lanes row) {
    constexpr int shift = std::countr_zero(static_cast<unsigned>(shadow_tile));
    return (truncated(row) >> shift) * shadow_tiles(map.side) + (truncated(column) >> shift);
}

/// Whether movers may be in the way of the light: tiles are noted as far around them as the filter reaches.
template <typename Isa>
CAMRIG_LANES IntLanes may_show_movers(const ShadowInView& map, const Lanes3& position) {
    const ShadowPlace place = shadow_place(map, position);
    return gathered<Isa>(map.movers,
                         shadow_tile_of(map, shadow_corner(map, place.column), shadow_corner(map, place.row))) != 0;
}

/// How much deeper the plane of a point is a texel to the right, and one down.
struct ShadowSlope {
    Lanes right, down;
};
CAMRIG_LANES ShadowSlope shadow_slope(const ShadowInView& map, const Lanes3& position, const Lanes3& n) {
    const Lanes distance = -dot(n, position);
    const auto of = [&](const glm::vec4& row) __attribute__((always_inline)) {
        return n.x * row.x + n.y * row.y + n.z * row.z + distance * row.w;
    };
    const Lanes per_depth = -1.0f / of(map.planes[2]);
    return {of(map.planes[0]) * per_depth, of(map.planes[1]) * per_depth};
}

/// Share of the light that one map lets through to the points, whose surface has normal n; all of it where they are not
/// in it. towards: the light, unit. Each texel is compared with the depth of the point's own plane there (J. Isidoro,
/// Shadow mapping: GPU-based tips and techniques, 2006); the bias is for what is not quite flat.
template <typename Isa>
CAMRIG_LANES Lanes share_in_map(const ShadowInView& map, bool has_movers, const Lanes3& position, const Lanes3& n,
                                const Lanes3& towards) {
    const Lanes cosine = dot(n, towards), used_cosine = max(cosine, lanes(least_shadow_cosine));
    const Lanes side = map.texel_m + map.texel_per_m * max(along(map.rows[3], position), Lanes{});
    const ShadowPlace place = shadow_place(map, position + towards * (side * (shadow_bias_texels / used_cosine)));
    const ShadowSlope slope = shadow_slope(map, position, n + towards * (used_cosine - cosine));

    // The 3x3 tent that I. Castano (Shadow mapping summary, 2013) has in four bilinear fetches, texel by texel.
    const Lanes column = shadow_corner(map, place.column), row = shadow_corner(map, place.row);
    const Lanes s = clamp01(place.column + 0.5f - column), t = clamp01(place.row + 0.5f - row);
    const IntLanes tile = shadow_tile_of(map, column, row);
    const IntLanes of_movers = has_movers ? gathered<Isa>(map.movers, tile) : IntLanes{};

    // Most points lie where all texels around are nearer to the light than they are, or none.
    const Lanes least = gathered<Isa>(&map.bounds->least, tile * 2), most = gathered<Isa>(&map.bounds->most, tile * 2);
    // The filter reaches two texels; a little more, for what rounding adds.
    const Lanes reach = 2.001f * (max(slope.right, -slope.right) + max(slope.down, -slope.down));
    const IntLanes is_lit = most <= place.depth - reach;
    const IntLanes is_known = (is_lit | (least > place.depth + reach)) & (of_movers == 0);
    const Lanes down = ((1.0f - t + (2.0f - t)) + (1.0f + t)) + t;
    Lanes sum = (down * (1.0f - s) + down * (2.0f - s)) + (down * (1.0f + s) + down * s);
    sum = is_lit ? sum : Lanes{};

    const int stride = shadow_stride(map.side);
    const IntLanes first =
        (truncated(row) - shadow_filter_before) * stride + truncated(column) - shadow_filter_before + of_movers;
    using Floats4 = float __attribute__((vector_size(16)));
    static_assert(shadow_filter_before + 1 + shadow_filter_behind == 4);
    for (unsigned left = Isa::bits(~is_known); left != 0; left &= left - 1) {
        const int k = std::countr_zero(left);
        const float* from = map.texels + first[k];
        const float below = t[k], right = s[k];
        const std::array<float, 4> weights{1.0f - below, 2.0f - below, 1.0f + below, below};
        const Floats4 depth = place.depth[k] + slope.right[k] * (Floats4{-1.0f, 0.0f, 1.0f, 2.0f} - right);
        Floats4 lit{};
        for (std::size_t r = 0; r < 4; ++r, from += stride) {
            Floats4 texels;
            std::memcpy(&texels, from, sizeof texels);
            const float lower = slope.down[k] * (static_cast<float>(r) - 1.0f - below);
            lit += texels <= depth + lower ? Floats4{} + weights[r] : Floats4{};
        }
        lit *= Floats4{1.0f - right, 2.0f - right, 1.0f + right, right};
        sum[k] = (lit[0] + lit[1]) + (lit[2] + lit[3]);
    }
    return sum * (1.0f / 16.0f);
}

/// Share of a light that reaches the points, whose surface has normal n: what its maps, of which there is at least one,
/// let through. towards: the light, unit.
template <typename Isa>
CAMRIG_LANES Lanes lit_share(std::span<const ShadowInView> maps, bool has_movers, const Lanes3& position,
                             const Lanes3& n, const Lanes3& towards) {
    if (maps.size() == 1) return share_in_map<Isa>(maps.front(), has_movers, position, n, towards);
    // Sides of a cube overlap by more than a filter reaches: of two that see a point one is right, and the other lacks
    // at most what is before the point.
    Lanes least = lanes(1.0f);
    for (const ShadowInView& map : maps) {
        const ShadowPlace place = shadow_place(map, position);
        const IntLanes is_seen = (min(place.column, place.row) > 0.0f) &
                                 (max(place.column, place.row) < static_cast<float>(shadow_stride(map.side)));
        if (Isa::bits(is_seen) == 0) continue;
        const Lanes share = share_in_map<Isa>(map, has_movers, position, n, towards);
        least = is_seen ? min(least, share) : least;
    }
    return least;
}

}  // namespace camrig::render::software
