#include "core/render/software/rasterizer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>

#include "core/base/cpu_features.h"
#include "core/frame/srgb.h"
#include "core/render/software/coverage.h"
#include "core/render/software/marked_pixels.h"
#include "core/render/software/shading.h"
#include "core/render/software/surface_point.h"

namespace camrig::render::software {
namespace {

/// Its pixels lie in one group of each row, and few rows.
CAMRIG_LANES bool is_small(const ScreenTriangle& triangle, const PixelRect& rect) {
    constexpr int side = 4;
    return triangle.x1 - triangle.x0 <= side && triangle.y1 - triangle.y0 <= side &&
           (rect.x0 & -lane_count) == ((rect.x1 - 1) & -lane_count);
}

/// find_visible for a small triangle, as most of people's are. The same arithmetic.
CAMRIG_LANES void find_small(const Setup& s, const PixelRect& rect, Rows<float> depths, Rows<std::uint32_t> numbers,
                             std::uint32_t number) {
    const auto [x0, y0, x1, y1] = rect;
    const int first = x0 & -lane_count;
    const DepthPlane depth = depth_plane(s);
    std::array<std::int32_t, 3> row{}, bias{};  // at the first pixel of the group
    for (std::size_t i = 0; i < 3; ++i) {
        bias[i] = s.dy[i] < 0 || (s.dy[i] == 0 && s.dx[i] > 0) ? 0 : -1;
        row[i] = static_cast<std::int32_t>(edge(s, i, std::int64_t{first} * subpixels, std::int64_t{y0} * subpixels));
    }
    const IntLanes from = int_lane_numbers();
    std::array<IntLanes, 3> across{};
    for (std::size_t i = 0; i < 3; ++i) across[i] = from * (-s.dy[i] * subpixels) + bias[i];
    const IntLanes beside = (from + (first - x0)) | ((x1 - 1 - first) - from);
    for (int y = y0; y < y1; ++y) {
        auto* const kept = reinterpret_cast<Lanes*>(depths(y) + first);
        const IntLanes outside = (across[0] + row[0]) | (across[1] + row[1]) | (across[2] + row[2]) | beside;
        const Lanes z = depth_at(depth, row[1], row[2]);
        const IntLanes mask = (outside >= 0) & (z > *kept);
        *kept = mask ? z : *kept;
        store(numbers(y), first, mask, IntLanes{} + static_cast<std::int32_t>(number));
        for (std::size_t i = 0; i < 3; ++i) row[i] += s.dx[i] * subpixels;
    }
}

template <typename Isa>
CAMRIG_LANES void find_visible_body(const ViewGeometry& geometry, std::uint32_t first, std::uint32_t count,
                                    const PixelRect& rect, const Canvas& canvas, const TriangleNumbers& numbers) {
    const Rows<float> depths = canvas.depth;
    const Rows<std::uint32_t> number_rows = numbers.rows();
    for (std::uint32_t i = first; i < first + count; ++i) {
        const ScreenTriangle& triangle = geometry.triangles()[i];
        const PixelRect seen = pixels_of(triangle, rect);
        if (seen.width() <= 0 || seen.height() <= 0) continue;
        const ViewDraw& draw = geometry.draws()[triangle.draw];
        const world::Material& material = *draw.primitive->material;
        const bool is_masked = material.alpha_mode == world::AlphaMode::mask;
        const Setup s = set_up(geometry, i);
        if (s.ray == nullptr && !is_masked && is_small(triangle, seen)) {
            find_small(s, seen, depths, number_rows, i + 1);
            continue;
        }
        rasterize<Isa>(geometry, s, seen, [&](int x, int y, IntLanes mask, Lanes depth) __attribute__((always_inline)) {
            auto* const kept = reinterpret_cast<Lanes*>(depths(y) + x);
            mask &= depth > *kept;
            if (Isa::bits(mask) == 0) return;
            if (is_masked) {
                const OneTriangle one(geometry, draw, triangle, s);
                SurfacePoints points = points_of<PointValues::of_alpha>(geometry, draw, one, x, y);
                TexturePoints& at = points.textures[base_color_slot];
                at.has_footprints = at.blends_levels = false;  // whatever colour is made of
                const Lanes alpha = base_alpha<Isa>(draw, points);
                mask &= alpha >= material.alpha_cutoff;
            }
            *kept = mask ? depth : *kept;
            store(number_rows(y), x, mask, IntLanes{} + static_cast<std::int32_t>(i + 1));
        });
    }
}

/// Pixels of draws that fill few lanes where they lie, until there are enough of one draw for all lanes.
class WaitingPixels {
public:
    struct Pixels {
        std::uint32_t draw = 0, count = 0;
        IntLanes number{}, first{}, lane{}, y{};

        /// Lanes that are left have the first pixel, too.
        CAMRIG_LANES void fill_up() {
            const IntLanes is_there = int_lane_numbers() < static_cast<std::int32_t>(count);
            for (IntLanes* of : {&number, &first, &lane, &y}) *of = is_there ? *of : IntLanes{} + (*of)[0];
        }
    };

    /// The pixels that are to be shaded before this one can wait; null: it does.
    CAMRIG_LANES Pixels* add(std::uint32_t draw, std::uint32_t number, int first, int lane, int y) {
        Pixels& waiting = of_draw_[draw % of_draw_.size()];
        if (waiting.count == lane_count || (waiting.count != 0 && waiting.draw != draw)) return &waiting;
        const auto at = static_cast<int>(waiting.count++);
        waiting.draw = draw;
        waiting.number[at] = static_cast<std::int32_t>(number);
        waiting.first[at] = first;
        waiting.lane[at] = lane;
        waiting.y[at] = y;
        return nullptr;
    }
    std::span<Pixels> all() { return of_draw_; }

private:
    /// Draws that are seen at once have places of their own, most often.
    std::array<Pixels, 64> of_draw_{};
};

template <typename Isa>
CAMRIG_LANES void shade_visible_body(const ViewGeometry& geometry, const PixelRect& rect, const Canvas& canvas,
                                     const TriangleNumbers& numbers, bool has_movers) {
    // A draw that has fewer lanes of a group than this waits for more pixels.
    constexpr int enough = 6;
    const ScreenTriangle* const triangles = geometry.triangles().data();
    const Rows<std::uint32_t> colors = canvas.color, number_rows = numbers.rows();
    const auto code_of = [](const Rgba& color) __attribute__((always_inline)) {
        return pixels_of({srgb(color.rgb.x), srgb(color.rgb.y), srgb(color.rgb.z)});
    };
    WaitingPixels waiting;
    const auto shade_waiting = [&](WaitingPixels::Pixels& pixels) __attribute__((always_inline)) {
        pixels.fill_up();
        const ViewDraw& draw = geometry.draws()[pixels.draw];
        const PixelLanes at{pixels.first, pixels.lane, pixels.y};
        const SurfacePoints points =
            points_of(geometry, draw, TriangleOfPixels<Isa>(geometry, draw, pixels.number, at), 0, 0);
        const Rgba color = shade<Isa>(geometry, draw, points, rays_through<Isa>(geometry, at), has_movers);
        const IntLanes codes = code_of(color);
        for (int i = 0; i < static_cast<int>(pixels.count); ++i) {
            const int x = pixels.first[i] + pixels.lane[i], row = pixels.y[i];
            if (canvas.light) {
                canvas.light.red(row)[x] = color.rgb.x[i];
                canvas.light.green(row)[x] = color.rgb.y[i];
                canvas.light.blue(row)[x] = color.rgb.z[i];
            } else {
                colors(row)[x] = static_cast<std::uint32_t>(codes[i]);
            }
        }
        pixels.count = 0;
    };
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0 & -lane_count; x < rect.x1; x += lane_count) {
            std::uint32_t* const of_group = number_rows(y) + x;
            const IntLanes number = *reinterpret_cast<const IntLanes*>(of_group);
            const IntLanes drawn = number != 0;
            unsigned left = Isa::bits(drawn);
            if (left == 0) continue;
            while (left != 0) {
                const std::uint32_t first = of_group[std::countr_zero(left)];
                const ScreenTriangle& triangle = triangles[first - 1];
                const ViewDraw& draw = geometry.draws()[triangle.draw];
                IntLanes mask = number == static_cast<std::int32_t>(first);
                const bool is_one = (left & ~Isa::bits(mask)) == 0;
                // All pixels of one draw at once; most often they are all that are left.
                if (!is_one)
                    mask = drawn & (draws_of<Isa>(triangles, number) == static_cast<std::int32_t>(triangle.draw));
                const unsigned own_bits = Isa::bits(mask);
                left &= ~own_bits;
                if (std::popcount(own_bits) < enough) {
                    for (unsigned own = own_bits; own != 0; own &= own - 1) {
                        const int lane = std::countr_zero(own);
                        while (auto* const first_shaded = waiting.add(triangle.draw, of_group[lane], x, lane, y))
                            shade_waiting(*first_shaded);
                    }
                    continue;
                }
                const IntLanes own = mask ? number : IntLanes{} + static_cast<std::int32_t>(first);
                // Made in its place: it is large.
                const SurfacePoints points =
                    is_one ? points_of(geometry, draw,
                                       OneTriangle(geometry, draw, triangle, set_up(geometry, first - 1)), x, y)
                           : points_of(geometry, draw, TriangleOfEach<Isa>(geometry, draw, own), x, y);
                const Rgba color = shade<Isa>(geometry, draw, points, rays_through(geometry, x, y), has_movers);
                if (canvas.light) {
                    store(canvas.light, x, y, mask, color.rgb);
                } else {
                    store(colors(y), x, mask, code_of(color));
                }
            }
            *reinterpret_cast<IntLanes*>(of_group) = IntLanes{};
        }
    }
    for (WaitingPixels::Pixels& pixels : waiting.all())
        if (pixels.count != 0) shade_waiting(pixels);
}

/// Of a group of pixels of a row, those that are not set.
CAMRIG_LANES IntLanes are_unset(const MarkedPixels& marked, int x, int y) {
    const std::uint64_t bits = marked.row(y)[x / MarkedPixels::word_bits] >> (x % MarkedPixels::word_bits);
    return (((IntLanes{} + static_cast<std::int32_t>(bits & 0xFF)) >> int_lane_numbers()) & 1) - 1;
}

template <typename Isa>
CAMRIG_LANES void blend_body(const ViewGeometry& geometry, std::uint32_t first, std::uint32_t count,
                             const PixelRect& rect, const Canvas& canvas, const std::array<float, 256>& linear,
                             bool has_movers, const MarkedPixels* except) {
    const Rows<float> depths = canvas.depth;
    const Rows<std::uint32_t> colors = canvas.color;
    for (std::uint32_t i = first; i < first + count; ++i) {
        const ScreenTriangle& triangle = geometry.triangles()[i];
        const ViewDraw& draw = geometry.draws()[triangle.draw];
        const PixelRect seen = pixels_of(triangle, rect);
        if (seen.width() <= 0 || seen.height() <= 0) continue;
        const Setup s = set_up(geometry, i);
        rasterize<Isa>(geometry, s, seen, [&](int x, int y, IntLanes mask, Lanes depth) __attribute__((always_inline)) {
            mask &= depth > *reinterpret_cast<const Lanes*>(depths(y) + x);
            if (except != nullptr) mask &= are_unset(*except, x, y);
            if (Isa::bits(mask) == 0) return;
            const OneTriangle one(geometry, draw, triangle, s);
            const Rgba color = shade<Isa>(geometry, draw, points_of(geometry, draw, one, x, y),
                                          rays_through(geometry, x, y), has_movers);
            const Lanes alpha = clamp01(color.a);
            const Lanes3 through = color.tint * (1.0f - alpha);
            if (canvas.light)
                return store(canvas.light, x, y, mask, color.rgb * alpha + light_at(canvas.light, x, y) * through);
            const IntLanes pixels = load_lanes(colors(y) + x);
            const auto light = [&](int shift) __attribute__((always_inline)) {
                return gathered<Isa>(linear.data(), pixels >> shift & 0xFF);
            };
            const Lanes3 over{clamp01(color.rgb.x), clamp01(color.rgb.y), clamp01(color.rgb.z)};
            const Lanes3 mixed = over * alpha + Lanes3{light(0), light(8), light(16)} * through;
            store(colors(y), x, mask, pixels_of({srgb(mixed.x), srgb(mixed.y), srgb(mixed.z)}));
        });
    }
}

CAMRIG_WIDE void find_visible_wide(const ViewGeometry& geometry, std::uint32_t first, std::uint32_t count,
                                   const PixelRect& rect, const Canvas& canvas, const TriangleNumbers& numbers) {
    find_visible_body<Avx2Isa>(geometry, first, count, rect, canvas, numbers);
}
CAMRIG_WIDE void shade_visible_wide(const ViewGeometry& geometry, const PixelRect& rect, const Canvas& canvas,
                                    const TriangleNumbers& numbers, bool has_movers) {
    shade_visible_body<Avx2Isa>(geometry, rect, canvas, numbers, has_movers);
}
CAMRIG_WIDE void blend_wide(const ViewGeometry& geometry, std::uint32_t first, std::uint32_t count,
                            const PixelRect& rect, const Canvas& canvas, bool has_movers, const MarkedPixels* except) {
    blend_body<Avx2Isa>(geometry, first, count, rect, canvas, linear_of_code(), has_movers, except);
}

}  // namespace

bool has_wide_lanes() {
    return has_avx2();
}

void find_visible(const ViewGeometry& geometry, std::uint32_t first_triangle, std::uint32_t count,
                  const PixelRect& rect, const Canvas& canvas, const TriangleNumbers& numbers) {
    if (geometry.wide_lanes()) return find_visible_wide(geometry, first_triangle, count, rect, canvas, numbers);
    find_visible_body<PlainIsa>(geometry, first_triangle, count, rect, canvas, numbers);
}

void shade_visible(const ViewGeometry& geometry, const PixelRect& rect, const Canvas& canvas,
                   const TriangleNumbers& numbers, bool has_movers) {
    if (geometry.wide_lanes()) return shade_visible_wide(geometry, rect, canvas, numbers, has_movers);
    shade_visible_body<PlainIsa>(geometry, rect, canvas, numbers, has_movers);
}

void blend(const ViewGeometry& geometry, std::uint32_t first_triangle, std::uint32_t count, const PixelRect& rect,
           const Canvas& canvas, bool has_movers, const MarkedPixels* except) {
    if (geometry.wide_lanes()) return blend_wide(geometry, first_triangle, count, rect, canvas, has_movers, except);
    blend_body<PlainIsa>(geometry, first_triangle, count, rect, canvas, linear_of_code(), has_movers, except);
}

const std::array<float, 256>& linear_of_code() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> made{};
        for (std::size_t i = 0; i < made.size(); ++i) {
            made[i] = static_cast<float>(frame::linear_of_srgb(static_cast<double>(i) / 255.0));
        }
        return made;
    }();
    return table;
}

std::uint8_t srgb_code(float linear) {
    return static_cast<std::uint8_t>(code(srgb(lanes(linear)))[0]);
}

}  // namespace camrig::render::software
