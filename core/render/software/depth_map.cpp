#include "core/render/software/depth_map.h"

#include "core/render/software/coverage.h"
#include "core/render/software/shading.h"
#include "core/render/software/surface_point.h"

namespace camrig::render::software {
namespace {

template <typename Isa>
CAMRIG_LANES void draw_depth_body(const ViewGeometry& geometry, const PixelRect& rect, Rows<float> depths) {
    for (std::uint32_t i = 0; i < geometry.triangles().size(); ++i) {
        const ScreenTriangle& triangle = geometry.triangles()[i];
        const PixelRect seen = pixels_of(triangle, rect);
        if (seen.width() <= 0 || seen.height() <= 0) continue;
        const ViewDraw& draw = geometry.draws()[triangle.draw];
        const world::Material& material = *draw.primitive->material;
        const Setup s = set_up(geometry, i);
        rasterize<Isa>(s, seen, [&](int x, int y, IntLanes mask, Lanes depth) __attribute__((always_inline)) {
            auto* const kept = reinterpret_cast<Lanes*>(depths(y) + x);
            mask &= depth > *kept;
            if (Isa::bits(mask) == 0) return;
            if (material.alpha_mode == world::AlphaMode::mask) {
                const OneTriangle one(geometry, draw, triangle, s);
                mask &= base_alpha<Isa>(draw, points_of<PointValues::of_alpha>(geometry, draw, one, x, y)) >=
                        material.alpha_cutoff;
            }
            *kept = mask != 0 ? depth : *kept;
        });
    }
}

CAMRIG_WIDE void draw_depth_wide(const ViewGeometry& geometry, const PixelRect& rect, Rows<float> depths) {
    draw_depth_body<Avx2Isa>(geometry, rect, depths);
}

}  // namespace

void draw_depth(const ViewGeometry& geometry, const PixelRect& rect, Rows<float> depth) {
    if (geometry.wide_lanes()) return draw_depth_wide(geometry, rect, depth);
    draw_depth_body<PlainIsa>(geometry, rect, depth);
}

}  // namespace camrig::render::software
