#include "core/render/software/lens_vertices.h"

#include <algorithm>

#include "core/render/software/lens_formula.h"

namespace camrig {
namespace {

template <typename Isa>
CAMRIG_LANES void project_body(const LensNumbers& lens, ImageSize size, const glm::dmat4& m, const glm::vec3* positions,
                               std::span<const std::uint32_t> which, ScreenVertex* to, glm::vec2* ideal,
                               std::int32_t* outside) {
    constexpr double farthest = 1e30;
    const float* const from = &positions->x;
    const double right = size.width - 0.5, bottom = size.height - 0.5;
    const float seen = lens.seen + std::sqrt(lens.straight_length2);
    for (std::size_t i = 0; i < which.size(); i += lane_count) {
        IntLanes at{};
        const std::size_t count = std::min<std::size_t>(which.size() - i, lane_count);
        for (std::size_t k = 0; k < lane_count; ++k)
            at[static_cast<int>(k)] = static_cast<std::int32_t>(which[i + std::min(k, count - 1)]);
        const Doubles local_x = widened(gathered<Isa>(from, at * 3));
        const Doubles local_y = widened(gathered<Isa>(from + 1, at * 3));
        const Doubles local_z = widened(gathered<Isa>(from + 2, at * 3));
        const auto row = [&](int r) __attribute__((always_inline)) {
            return local_x * m[0][r] + local_y * m[1][r] + local_z * m[2][r] + m[3][r];
        };
        const Doubles x = row(0), y = row(1), z = row(2);
        const Doubles w = lens.is_wide ? sqrt(x * x + y * y + z * z) : z;
        const Doubles reach = lens.is_wide ? Doubles{} + farthest : z * lens.guard;
        // Not of a number: never inside.
        const IntLanes in_guard = (magnitude(x) <= reach) & (magnitude(y) <= reach) & (w <= Doubles{} + farthest);
        const IntLanes is_near = w < Doubles{} + lens.near_m;
        const IntLanes is_placed = in_guard & ~is_near;
        const Doubles one = Doubles{} + 1.0, inverse = 1.0 / select(is_placed, w, one);
        const Doubles u = select(is_placed, x, Doubles{}) * inverse, v = select(is_placed, y, Doubles{}) * inverse;
        const Doubles ahead = lens.is_wide ? select(is_placed, z, one) * inverse : one;
        const auto seen_at = through_lens<Lanes>(lens, narrowed(u), narrowed(v), narrowed(ahead));
        const Doubles factor = widened(seen_at.factor);
        const Doubles px = (u * factor + widened(seen_at.aside_x)) * lens.k.fx + lens.k.cx;
        const Doubles py = (v * factor + widened(seen_at.aside_y)) * lens.k.fy + lens.k.cy;
        const IntLanes beyond = ((px < Doubles{} + -0.5) & outside_left) | ((Doubles{} + right < px) & outside_right) |
                                ((py < Doubles{} + -0.5) & outside_top) | ((Doubles{} + bottom < py) & outside_bottom) |
                                ((seen_at.radius > seen) & outside_lens);
        const IntLanes bits = is_placed ? beyond : (is_near & outside_near) | (~in_guard & outside_guard);
        const IntLanes sx = rounded(px * static_cast<double>(subpixels));
        const IntLanes sy = rounded(py * static_cast<double>(subpixels));
        const Lanes depth = narrowed(inverse * lens.depth_shift + lens.depth_scale), inverse_w = narrowed(inverse);
        for (int k = 0; k < lane_count; ++k) {
            to[at[k]] = {sx[k], sy[k], depth[k], inverse_w[k]};
            ideal[at[k]] = {seen_at.ideal_x[k], seen_at.ideal_y[k]};
            outside[at[k]] = bits[k];
        }
    }
}

CAMRIG_WIDE void project_wide(const LensNumbers& lens, ImageSize size, const glm::dmat4& optical_from_local,
                              const glm::vec3* positions, std::span<const std::uint32_t> which, ScreenVertex* to,
                              glm::vec2* ideal, std::int32_t* outside) {
    project_body<Avx2Isa>(lens, size, optical_from_local, positions, which, to, ideal, outside);
}

}  // namespace

void project_through(const LensNumbers& lens, ImageSize size, const glm::dmat4& optical_from_local,
                     const glm::vec3* positions, std::span<const std::uint32_t> which, bool wide, ScreenVertex* to,
                     glm::vec2* ideal, std::int32_t* outside) {
    if (wide) return project_wide(lens, size, optical_from_local, positions, which, to, ideal, outside);
    project_body<PlainIsa>(lens, size, optical_from_local, positions, which, to, ideal, outside);
}

}  // namespace camrig
