#include "core/render/software/view_rows.h"

#include <algorithm>

#include "core/render/software/area_rows.h"

namespace camrig {
namespace {

template <typename T>
void fill(Rows<T> rows, const PixelRect& rect, T value) {
    for (int y = rect.y0; y < rect.y1; ++y) std::fill_n(rows(y) + rect.x0, rect.width(), value);
}

std::uint32_t pixel_of(const glm::vec3& linear) {
    return srgb_code(linear.r) | std::uint32_t{srgb_code(linear.g)} << 8 | std::uint32_t{srgb_code(linear.b)} << 16 |
           0xFFu << 24;
}

void draw_opaque(ViewScratch& scratch, const TriangleRange& triangles, const ViewWork& work, const PixelRect& band) {
    if (triangles.count == 0 || work.rects.empty()) return;
    const PixelRect hull = common(hull_of(work.rects), band);
    if (hull.height() <= 0) return;
    // What is in the range lies in the rectangles: once for all of them.
    find_visible(scratch.geometry, triangles.first, triangles.count, hull, work.canvas, scratch.numbers);
    for (const PixelRect& rect : work.rects)
        shade_visible(scratch.geometry, common(rect, band), work.canvas, scratch.numbers);
}

void draw_blended(const ViewScratch& scratch, std::span<const ViewDraw> draws, const ViewWork& work,
                  const PixelRect& band) {
    for (const PixelRect& rect : work.rects) {
        for (const ViewDraw& draw : draws)
            blend(scratch.geometry, draw.first_triangle, draw.triangle_count, common(rect, band), work.canvas);
    }
}

}  // namespace

PixelRect common(const PixelRect& a, const PixelRect& b) {
    return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

PixelRect hull_of(std::span<const PixelRect> rects) {
    PixelRect hull = rects.front();
    for (const PixelRect& rect : rects)
        hull = {std::min(hull.x0, rect.x0), std::min(hull.y0, rect.y0), std::max(hull.x1, rect.x1),
                std::max(hull.y1, rect.y1)};
    return hull;
}

void put_back(ViewWork& work, const PixelRect& band) {
    const StaticLayer& layer = *work.layer;
    const Rows<std::uint32_t> color = layer.color.rows();
    const Rows<std::uint32_t> finished = layer.finished ? layer.finished.rows() : color;
    for (const PixelRect& rect : work.stale) copy(finished, rows_of(*work.frame), common(rect, band));
    for (const PixelRect& rect : work.rects) {
        if (!work.is_in_frame || layer.finished) copy(color, work.canvas.color, common(rect, band));
        copy(layer.depth.rows(), work.canvas.depth, common(rect, band));
    }
}

void draw_background(ViewWork& work, const PixelRect& band) {
    const Environment& environment = work.scene.scene->environment();
    fill(work.canvas.color, band, pixel_of(environment.background * environment.exposure));
    fill(work.canvas.depth, band, 0.0f);
}

void keep_layer(ViewWork& work, ViewScratch& scratch, const PixelRect& band) {
    const Canvas& canvas = work.canvas;
    const StaticLayer& layer = *work.layer;
    copy(canvas.color, layer.color.rows(), band);
    copy(canvas.depth, layer.depth.rows(), band);
    if (!layer.finished) return;
    draw_blended(scratch, scratch.blended_statics, work, band);
    copy(canvas.color, layer.finished.rows(), band);
    copy(layer.color.rows(), canvas.color, band);
}

void finish_rows(ViewWork& work, ViewScratch& scratch, const PixelRect& band) {
    draw_blended(scratch, scratch.blended, work, band);
    if (work.is_in_frame) return;
    for (const PixelRect& rect : work.rects) copy(work.canvas.color, rows_of(*work.frame), common(rect, band));
}

PixelRect band_of(const ViewWork& work, int band, int bands) {
    // The work lies where the rectangles are.
    const PixelRect busy = work.rects.empty() ? work.whole : hull_of(work.rects);
    const auto row = [&](int i) {
        return i == 0 ? 0 : i == bands ? work.whole.y1 : busy.y0 + busy.height() * i / bands;
    };
    return {0, row(band), work.whole.x1, row(band + 1)};
}

int passes_of(const ViewWork& work) {
    return work.has_areas ? pass_count : 1;
}

void draw_rows(ViewWork& work, ViewScratch& scratch, int pass, int number, int bands) {
    const PixelRect band = band_of(work, number, bands);
    if (work.has_areas) return draw_area_rows(work, scratch, pass, number, band);
    if (pass > 0) return;
    if (work.is_in_parts) {
        put_back(work, band);
    } else {
        draw_background(work, band);
        if (work.layer != nullptr) {
            draw_opaque(scratch, scratch.statics, work, band);
            keep_layer(work, scratch, band);
        }
    }
    draw_opaque(scratch, scratch.movers, work, band);
    finish_rows(work, scratch, band);
}

}  // namespace camrig
