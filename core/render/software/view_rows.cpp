#include "core/render/software/view_rows.h"

#include <algorithm>
#include <cstring>

namespace camrig {
namespace {

template <typename T>
void copy(Rows<T> from, Rows<T> to, const PixelRect& rect) {
    if (rect.width() <= 0) return;
    const auto bytes = static_cast<std::size_t>(rect.width()) * sizeof(T);
    for (int y = rect.y0; y < rect.y1; ++y) std::memcpy(to(y) + rect.x0, from(y) + rect.x0, bytes);
}

template <typename T>
void fill(Rows<T> rows, const PixelRect& rect, T value) {
    for (int y = rect.y0; y < rect.y1; ++y) std::fill_n(rows(y) + rect.x0, rect.width(), value);
}

std::uint32_t pixel_of(const glm::vec3& linear) {
    return srgb_code(linear.r) | std::uint32_t{srgb_code(linear.g)} << 8 | std::uint32_t{srgb_code(linear.b)} << 16 |
           0xFFu << 24;
}

/// May be of less than no height.
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

/// What sees nothing is black whatever the background, and nothing comes before it.
void cover_blind(const LensView& lens, const Canvas& canvas, const PixelRect& band) {
    constexpr std::uint32_t black = 0xFFu << 24;
    const auto first = std::ranges::lower_bound(lens.blind(), band.y0, {}, &LensView::BlindRun::y);
    for (auto run = first; run != lens.blind().end() && run->y < band.y1; ++run) {
        std::fill_n(canvas.color(run->y) + run->x0, run->x1 - run->x0, black);
        std::fill_n(canvas.depth(run->y) + run->x0, run->x1 - run->x0, blind_depth);
    }
}

void draw_ground(ViewWork& work, ViewScratch& scratch, const PixelRect& band) {
    const Canvas& canvas = work.canvas;
    const Environment& environment = work.scene.scene->environment();
    fill(canvas.color, band, pixel_of(environment.background * environment.exposure));
    fill(canvas.depth, band, 0.0f);
    if (work.scene.lens != nullptr) cover_blind(*work.scene.lens, canvas, band);
    if (work.layer == nullptr) return;
    draw_opaque(scratch, scratch.statics, work, band);
    const StaticLayer& layer = *work.layer;
    copy(canvas.color, layer.color.rows(), band);
    copy(canvas.depth, layer.depth.rows(), band);
    if (!layer.finished) return;
    draw_blended(scratch, scratch.blended_statics, work, band);
    copy(canvas.color, layer.finished.rows(), band);
    copy(layer.color.rows(), canvas.color, band);
}

}  // namespace

PixelRect band_of(const ViewWork& work, int band, int bands) {
    // The work lies where the rectangles are.
    const PixelRect busy = work.rects.empty() ? work.whole : hull_of(work.rects);
    const auto row = [&](int i) {
        return i == 0 ? 0 : i == bands ? work.whole.y1 : busy.y0 + busy.height() * i / bands;
    };
    return {0, row(band), work.whole.x1, row(band + 1)};
}

void draw_rows(ViewWork& work, ViewScratch& scratch, const PixelRect& band) {
    if (work.is_in_parts) {
        put_back(work, band);
    } else {
        draw_ground(work, scratch, band);
    }
    draw_opaque(scratch, scratch.movers, work, band);
    draw_blended(scratch, scratch.blended, work, band);
    if (!work.is_in_frame) {
        for (const PixelRect& rect : work.rects) copy(work.canvas.color, rows_of(*work.frame), common(rect, band));
    }
}

}  // namespace camrig
