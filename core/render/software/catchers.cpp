#include "core/render/software/catchers.h"

#include <bit>

#include "core/render/software/rows.h"
#include "core/render/software/shading.h"
#include "core/render/software/shadow_lookup.h"

namespace camrig::render::software {
namespace {

/// Darker than any code of a picture: what has no light cannot lose any.
constexpr float least_light = 1e-6f;

/// The share of light that is left; 1 where it is the same.
CAMRIG_LANES Lanes share_of_light(Lanes with, Lanes without) {
    const Lanes share = clamp01(with / max(without, lanes(least_light)));
    return with == without ? lanes(1.0f) : share;
}

/// Of an object of the scene what it looks like, since its picture is what it looked like. What only a camera has is
/// a shape: nobody knows what the picture shows there, but that most of it is matt.
template <typename Isa>
CAMRIG_LANES Lanes3 light_of(const ViewGeometry& geometry, const ViewDraw& draw, const SurfacePoints& points,
                             const Lanes3& rays, bool has_movers) {
    if (draw.placed->object->id != ObjectId{}) return shade<Isa>(geometry, draw, points, rays, has_movers).rgb;
    Lanes3 made;
    const auto arriving_light = std::is_same_v<Isa, Avx2Isa> ? arriving_light_wide : arriving_light_plain;
    arriving_light(geometry, draw, points, rays, has_movers, made);
    return made;
}

/// Whether movers keep light of a lamp from the points: shading twice, which tells how much, is dear.
template <typename Isa>
CAMRIG_LANES IntLanes are_darkened(const ViewDraw& draw, const SurfacePoints& points, const Lanes3& rays) {
    const glm::mat3& m = draw.optical_from_normal;
    const Lanes3 turned = splat(m[0]) * points.normal.x + splat(m[1]) * points.normal.y + splat(m[2]) * points.normal.z;
    const Lanes3 normal = turned * (1.0f / sqrt(max(dot(turned, turned), lanes(1e-30f))));
    const Lanes3 position = rays * points.z;
    IntLanes found{};
    each_light(*draw.lights, true, position, [&](const ArrivingLight& light) __attribute__((always_inline)) {
        if (light.shadows.empty()) return;
        found |= lit_share<Isa>(light.shadows, true, position, normal, light.towards) !=
                 lit_share<Isa>(light.shadows, false, position, normal, light.towards);
    });
    return found;
}

template <typename Isa>
CAMRIG_LANES void darken_body(const ViewGeometry& geometry, std::uint32_t proxies, const PixelRect& rect,
                              const Canvas& canvas, Rows<std::uint32_t> number_rows,
                              const std::array<float, 256>& linear) {
    const ScreenTriangle* const triangles = geometry.triangles().data();
    const auto last = static_cast<std::int32_t>(proxies);
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0 & -lane_count; x < rect.x1; x += lane_count) {
            const IntLanes inside =
                ((int_lane_numbers() + (x - rect.x0)) | ((rect.x1 - 1 - x) - int_lane_numbers())) >= 0;
            const IntLanes number = load_lanes(number_rows(y) + x);
            const IntLanes caught = inside & (number > 0) & (number <= last);
            unsigned left = Isa::bits(caught);
            while (left != 0) {
                const int first = std::countr_zero(left);
                const ViewDraw& draw = geometry.draws()[triangles[static_cast<std::size_t>(number[first] - 1)].draw];
                const IntLanes mask =
                    caught & (draws_of<Isa>(triangles, caught ? number : IntLanes{} + number[first]) ==
                              static_cast<std::int32_t>(triangles[static_cast<std::size_t>(number[first] - 1)].draw));
                left &= ~Isa::bits(mask);
                if (!draw.primitive->is_lit) continue;
                const IntLanes own = mask ? number : IntLanes{} + number[first];
                const SurfacePoints points = points_of(geometry, draw, TriangleOfEach<Isa>(geometry, draw, own), x, y);
                const Lanes3 rays = rays_through(geometry, x, y);
                if (Isa::bits(mask & are_darkened<Isa>(draw, points, rays)) == 0) continue;
                const Lanes3 with = light_of<Isa>(geometry, draw, points, rays, true);
                const Lanes3 without = light_of<Isa>(geometry, draw, points, rays, false);
                const Lanes3 share{share_of_light(with.x, without.x), share_of_light(with.y, without.y),
                                   share_of_light(with.z, without.z)};
                const IntLanes changed = mask & ((share.x != 1.0f) | (share.y != 1.0f) | (share.z != 1.0f));
                if (Isa::bits(changed) == 0) continue;
                const IntLanes pixels = load_lanes(canvas.color(y) + x);
                const auto made = [&](int shift, Lanes channel) __attribute__((always_inline)) {
                    return srgb(gathered<Isa>(linear.data(), pixels >> shift & 0xFF) * channel);
                };
                store(canvas.color(y), x, changed, pixels_of({made(0, share.x), made(8, share.y), made(16, share.z)}));
            }
        }
    }
}

CAMRIG_WIDE void darken_wide(const ViewGeometry& geometry, std::uint32_t proxies, const PixelRect& rect,
                             const Canvas& canvas, Rows<std::uint32_t> numbers, const std::array<float, 256>& linear) {
    darken_body<Avx2Isa>(geometry, proxies, rect, canvas, numbers, linear);
}

}  // namespace

void find_receivers(ViewScratch& scratch, const PixelRect& rect, const Canvas& canvas, Rows<std::uint32_t> numbers) {
    const Rows<float> depth = scratch.receiver_depth.rows();
    const Rows<std::uint32_t> to = scratch.receivers.rows();
    copy(canvas.depth, depth, rect);
    fill(to, rect, 0u);
    find_visible(scratch.geometry, 0, scratch.catchers, rect, Canvas{{}, depth, {}}, scratch.receivers);
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) {
            // What is drawn is drawn before what only catches.
            if (to(y)[x] != 0 && numbers(y)[x] <= scratch.proxies) continue;
            to(y)[x] = numbers(y)[x];
            depth(y)[x] = canvas.depth(y)[x];
        }
    }
}

void darken_proxies(const ViewGeometry& geometry, std::uint32_t proxies, const PixelRect& rect, const Canvas& canvas,
                    Rows<std::uint32_t> numbers) {
    if (geometry.wide_lanes()) return darken_wide(geometry, proxies, rect, canvas, numbers, linear_of_code());
    darken_body<PlainIsa>(geometry, proxies, rect, canvas, numbers, linear_of_code());
}

void catch_shadows(const ViewGeometry& geometry, std::uint32_t proxies, bool has_shadows, const PixelRect& rect,
                   const Canvas& canvas, Rows<std::uint32_t> numbers) {
    if (proxies == 0) return;
    if (has_shadows) darken_proxies(geometry, proxies, rect, canvas, numbers);
    for (int y = rect.y0; y < rect.y1; ++y) {
        std::uint32_t* const row = numbers(y);
        for (int x = rect.x0; x < rect.x1; ++x) row[x] = row[x] <= proxies ? 0 : row[x];
    }
}

}  // namespace camrig::render::software
