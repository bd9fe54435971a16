#include "core/render/software/screen_triangles.h"

#include <algorithm>
#include <bit>

#include "core/render/software/lanes.h"
#include "core/render/software/local_points.h"

namespace camrig::render::software {
namespace {

/// Four by eight turned: a vertex of each lane.
CAMRIG_LANES void store_vertices(IntLanes x, IntLanes y, Lanes depth, Lanes inverse_z, IntLanes at, ScreenVertex* to) {
    const IntLanes d = reinterpret_cast<IntLanes>(depth), z = reinterpret_cast<IntLanes>(inverse_z);
    const IntLanes xy_low = __builtin_shufflevector(x, y, 0, 8, 1, 9, 4, 12, 5, 13);
    const IntLanes xy_high = __builtin_shufflevector(x, y, 2, 10, 3, 11, 6, 14, 7, 15);
    const IntLanes dz_low = __builtin_shufflevector(d, z, 0, 8, 1, 9, 4, 12, 5, 13);
    const IntLanes dz_high = __builtin_shufflevector(d, z, 2, 10, 3, 11, 6, 14, 7, 15);
    const std::array<IntLanes, 4> pairs{__builtin_shufflevector(xy_low, dz_low, 0, 1, 8, 9, 4, 5, 12, 13),
                                        __builtin_shufflevector(xy_low, dz_low, 2, 3, 10, 11, 6, 7, 14, 15),
                                        __builtin_shufflevector(xy_high, dz_high, 0, 1, 8, 9, 4, 5, 12, 13),
                                        __builtin_shufflevector(xy_high, dz_high, 2, 3, 10, 11, 6, 7, 14, 15)};
    for (int k = 0; k < 4; ++k) {
        const IntLanes& pair = pairs[static_cast<std::size_t>(k)];
        store_lanes(to + at[k], __builtin_shufflevector(pair, pair, 0, 1, 2, 3));
        store_lanes(to + at[k + 4], __builtin_shufflevector(pair, pair, 4, 5, 6, 7));
    }
}

template <typename Isa>
CAMRIG_LANES void project_body(const ViewTransform& t, const glm::dmat4& m, const glm::vec3* positions,
                               std::span<const std::uint32_t> which, ScreenVertex* to, std::int32_t* outside) {
    static_assert(sizeof(ScreenVertex) == 16);
    const double left = t.intrinsics.cx + 0.5, right = t.size.width - 0.5 - t.intrinsics.cx;
    const double top = t.intrinsics.cy + 0.5, bottom = t.size.height - 0.5 - t.intrinsics.cy;
    const double guard_x = guard_px - std::abs(t.intrinsics.cx), guard_y = guard_px - std::abs(t.intrinsics.cy);
    for (std::size_t i = 0; i < which.size(); i += lane_count) {
        const IntLanes at = indices_at(which.data() + i, which.size() - i);
        const PointLanes point = transformed<Isa>(m, positions, at);
        const Doubles x = point.x * t.intrinsics.fx, y = point.y * t.intrinsics.fy, z = point.z;
        // Not of a number: never inside.
        const IntLanes in_guard = (magnitude(x) <= z * guard_x) & (magnitude(y) <= z * guard_y);
        const IntLanes beyond = ((x < z * -left) & outside_left) | ((z * right < x) & outside_right) |
                                ((y < z * -top) & outside_top) | ((z * bottom < y) & outside_bottom) |
                                ((z < Doubles{} + t.near_m) & outside_near) | (~in_guard & outside_guard);
        const IntLanes is_placed = (beyond & (outside_near | outside_guard)) == 0;
        const Doubles inverse = 1.0 / select(is_placed, z, Doubles{} + 1.0);
        const Doubles u = select(is_placed, x, Doubles{}) * inverse + t.intrinsics.cx;
        const Doubles v = select(is_placed, y, Doubles{}) * inverse + t.intrinsics.cy;
        store_vertices(rounded(u * static_cast<double>(subpixels)), rounded(v * static_cast<double>(subpixels)),
                       narrowed(inverse * t.depth_shift + t.depth_scale), narrowed(inverse), at, to);
        for (int k = 0; k < lane_count; ++k) outside[at[k]] = beyond[k];
    }
}

/// Half of all triangles show their backs and most of far people's lie between the pixels: no branch would guess which.
template <typename Isa>
CAMRIG_LANES void assemble_body(const scene::TriangleCorners& corners, const ScreenVertex* vertices,
                                const std::int32_t* outside, const TriangleRule& rule, OutlineScratch& scratch,
                                std::vector<ScreenTriangle>& to, scene::TriangleCorners& to_clip) {
    constexpr std::int32_t beside = outside_left | outside_right | outside_top | outside_bottom | outside_near;
    constexpr int bits = 8;
    const std::size_t count = corners[0].size(), first = to.size();
    to.resize(first + count);
    ScreenTriangle* next = to.data() + first;
    scratch.facing.assign(rule.neighbors != nullptr ? count : 0, facing_unknown);
    scratch.sources.resize(rule.neighbors != nullptr ? count : 0);
    std::uint32_t* source = scratch.sources.data();
    for (std::size_t i = 0; i < count; i += lane_count) {
        std::array<IntLanes, 3> corner, x, y, beyond;
        for (std::size_t c = 0; c < 3; ++c) {
            corner[c] = indices_at(corners[c].data() + i, count - i);
            beyond[c] = gathered<Isa>(outside, corner[c]);
        }
        const IntLanes is_there =
            int_lane_numbers() < static_cast<std::int32_t>(std::min<std::size_t>(count - i, lane_count));
        const IntLanes is_whole = ((beyond[0] | beyond[1] | beyond[2]) & (outside_near | outside_guard)) == 0;
        const IntLanes is_beside = (beyond[0] & beyond[1] & beyond[2] & beside) != 0;
        const IntLanes may_show = is_there & ~is_beside;
        for (unsigned left = Isa::bits(may_show & ~is_whole); left != 0; left &= left - 1) {
            for (std::size_t c = 0; c < 3; ++c)
                to_clip[c].push_back(static_cast<std::uint32_t>(corner[c][std::countr_zero(left)]));
        }
        if (Isa::bits(may_show & is_whole) == 0) continue;
        for (std::size_t c = 0; c < 3; ++c) {
            x[c] = gathered<Isa>(&vertices->x, corner[c] * 4);
            y[c] = gathered<Isa>(&vertices->y, corner[c] * 4);
        }
        // Coordinates are below 2^23: these doubles are whole numbers.
        const Doubles area = widened(x[1] - x[0]) * widened(y[2] - y[0]) - widened(x[2] - x[0]) * widened(y[1] - y[0]);
        const Lanes sign = narrowed(area);
        const IntLanes x0 = (min(x[0], min(x[1], x[2])) + (subpixels - 1)) >> bits;
        const IntLanes y0 = (min(y[0], min(y[1], y[2])) + (subpixels - 1)) >> bits;
        const IntLanes x1 = (max(x[0], max(x[1], x[2])) >> bits) + 1;
        const IntLanes y1 = (max(y[0], max(y[1], y[2])) >> bits) + 1;
        // Rows run down, so what is counter-clockwise in the world is negative here.
        const IntLanes is_turned = sign < 0.0f;
        const IntLanes is_front = rule.turns_clockwise ? ~is_turned : is_turned;
        const IntLanes is_seen = rule.is_double_sided ? IntLanes{} - 1 : is_front;
        const IntLanes has_middles = rule.keeps_thin ? IntLanes{} - 1 : (x0 < x1) & (y0 < y1);
        const IntLanes is_kept = may_show & is_whole & is_seen & (sign != 0.0f) & has_middles;
        if (rule.neighbors != nullptr) {
            const IntLanes facing =
                is_whole & (sign != 0.0f) & (is_turned ? IntLanes{} + facing_turned : IntLanes{} + facing_straight);
            for (std::size_t k = 0; k < std::min<std::size_t>(count - i, lane_count); ++k)
                scratch.facing[i + k] = static_cast<std::uint8_t>(facing[static_cast<int>(k)]);
        }
        const Doubles inverse_area = 1.0 / magnitude(area);
        const IntLanes second = is_turned ? corner[2] : corner[1], third = is_turned ? corner[1] : corner[2];
        for (unsigned left = Isa::bits(is_kept); left != 0; left &= left - 1) {
            const int k = std::countr_zero(left);
            ScreenTriangle& made = *next++;
            made.vertices = {rule.first_vertex + static_cast<std::uint32_t>(corner[0][k]),
                             rule.first_vertex + static_cast<std::uint32_t>(second[k]),
                             rule.first_vertex + static_cast<std::uint32_t>(third[k])};
            made.draw = rule.draw & max_draws;
            made.outline = rule.keeps_thin ? 7 : 0;
            if (rule.neighbors != nullptr) *source++ = static_cast<std::uint32_t>(i) + static_cast<std::uint32_t>(k);
            made.is_front = is_front[k] != 0;
            made.inverse_area = k < 4 ? inverse_area.low[k] : inverse_area.high[k - 4];
            made.x0 = static_cast<std::int16_t>(x0[k]);
            made.y0 = static_cast<std::int16_t>(y0[k]);
            made.x1 = static_cast<std::int16_t>(x1[k]);
            made.y1 = static_cast<std::int16_t>(y1[k]);
        }
    }
    to.resize(static_cast<std::size_t>(next - to.data()));
    if (rule.neighbors != nullptr) find_outline(*rule.neighbors, scratch, std::span(to).subspan(first));
}

CAMRIG_WIDE void project_wide(const ViewTransform& view, const glm::dmat4& optical_from_local,
                              const glm::vec3* positions, std::span<const std::uint32_t> which, ScreenVertex* to,
                              std::int32_t* outside) {
    project_body<Avx2Isa>(view, optical_from_local, positions, which, to, outside);
}
CAMRIG_WIDE void assemble_wide(const scene::TriangleCorners& corners, const ScreenVertex* vertices,
                               const std::int32_t* outside, const TriangleRule& rule, OutlineScratch& scratch,
                               std::vector<ScreenTriangle>& to, scene::TriangleCorners& to_clip) {
    assemble_body<Avx2Isa>(corners, vertices, outside, rule, scratch, to, to_clip);
}

}  // namespace

void find_outline(const MeshNeighbors& neighbors, const OutlineScratch& scratch, std::span<ScreenTriangle> triangles) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const std::uint32_t own = scratch.sources[i];
        const std::uint8_t facing = scratch.facing[own];
        std::array<std::uint32_t, 3> is_outline{};
        for (std::size_t c = 0; c < 3; ++c) {
            const std::int32_t beyond = neighbors[own][c];
            is_outline[c] = beyond < 0 || scratch.facing[static_cast<std::size_t>(beyond)] != facing;
        }
        // The second and third corner of a turned triangle are swapped.
        if (facing == facing_turned) std::swap(is_outline[1], is_outline[2]);
        triangles[i].outline = (is_outline[0] | is_outline[1] << 1 | is_outline[2] << 2) & 7u;
    }
}

void project(const ViewTransform& view, const glm::dmat4& optical_from_local, const glm::vec3* positions,
             std::span<const std::uint32_t> which, bool wide, ScreenVertex* to, std::int32_t* outside) {
    if (wide) return project_wide(view, optical_from_local, positions, which, to, outside);
    project_body<PlainIsa>(view, optical_from_local, positions, which, to, outside);
}

void assemble(const scene::TriangleCorners& corners, const ScreenVertex* vertices, const std::int32_t* outside,
              const TriangleRule& rule, bool wide, OutlineScratch& scratch, std::vector<ScreenTriangle>& to,
              scene::TriangleCorners& to_clip) {
    if (wide) return assemble_wide(corners, vertices, outside, rule, scratch, to, to_clip);
    assemble_body<PlainIsa>(corners, vertices, outside, rule, scratch, to, to_clip);
}

}  // namespace camrig::render::software
