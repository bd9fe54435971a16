#include "core/render/software/view_rows.h"

#include "core/render/software/area_rows.h"
#include "core/render/software/blended_areas.h"
#include "core/render/software/catchers.h"
#include "core/render/software/channels.h"
#include "core/render/software/matched_actors.h"
#include "core/render/software/mixed_pixels.h"
#include "core/render/software/panorama_rows.h"
#include "core/render/software/projected_rows.h"
#include "core/render/software/rows.h"
#include "core/render/software/taken_picture.h"

namespace camrig::render::software {
namespace {

const std::uint8_t* row_of(const world::Image& picture, int y) {
    return picture.rgba.data() +
           std::size_t{4} * static_cast<std::size_t>(picture.size.width) * static_cast<std::size_t>(y);
}

void fill_light(const LightRows& rows, const PixelRect& rect, const glm::vec3& light) {
    fill(rows.red, rect, light.r);
    fill(rows.green, rect, light.g);
    fill(rows.blue, rect, light.b);
}

/// Whether the view's backdrop has no picture of the view's own pixels.
bool is_sampled(const ViewWork& work) {
    return work.backdrop != nullptr && work.backdrop->is_sampled();
}

constexpr std::uint32_t alpha_bits = 0xFFu << 24;

void set_alpha(Rows<std::uint32_t> rows, const PixelRect& rect, bool is_opaque) {
    for (int y = rect.y0; y < rect.y1; ++y)
        for (int x = rect.x0; x < rect.x1; ++x)
            rows(y)[x] = is_opaque ? rows(y)[x] | alpha_bits : rows(y)[x] & ~alpha_bits;
}

/// The picture, and what a layer has over it, which is opaque or not there.
void show_picture_below(const world::Image& picture, Rows<std::uint32_t> layer, const PixelRect& rect,
                        Rows<std::uint32_t> to) {
    for (int y = rect.y0; y < rect.y1; ++y) {
        const std::uint8_t* const from = row_of(picture, y);
        const std::uint32_t* const over = layer(y);
        std::uint32_t* const out = to(y);
        int x = rect.x0;
        for (; x + lane_count <= rect.x1; x += lane_count) {
            const IntLanes above = load_lanes(over + x);
            // Alpha is its upper bits.
            store_lanes(out + x, above < 0 ? above : load_lanes(from + 4 * static_cast<std::ptrdiff_t>(x)));
        }
        for (; x < rect.x1; ++x) {
            std::memcpy(out + x, from + 4 * static_cast<std::ptrdiff_t>(x), sizeof *out);
            if (over[x] >= alpha_bits) out[x] = over[x];
        }
    }
}

/// scratch.numbers are those of what stands still.
void keep_receivers(ShadowedStatics& to, const ViewScratch& scratch, const PixelRect& band) {
    copy(scratch.numbers.rows(), to.numbers.rows(), band);
    if (scratch.catchers > 0) copy(scratch.receiver_depth.rows(), to.depth.rows(), band);
}

/// has_movers: as of shade_visible.
void draw_opaque(ViewScratch& scratch, const TriangleRange& triangles, ViewWork& work, const PixelRect& band,
                 bool has_movers) {
    // What nothing is in front of shows the picture, too.
    const bool lays_picture = &triangles == &scratch.statics && is_sampled(work) && work.backdrop->projected;
    const bool has_catchers = &triangles == &scratch.statics && scratch.catchers > 0;
    if ((triangles.count == 0 && !lays_picture && !has_catchers) || work.rects.empty()) return;
    const PixelRect hull = common(hull_of(work.rects), band);
    if (hull.height() <= 0) return;
    // What is in the range lies in the rectangles: once for all of them.
    find_visible(scratch.geometry, triangles.first, triangles.count, hull, work.canvas, scratch.numbers);
    for (const PixelRect& rect : work.rects) describe_visible(scratch, common(rect, band), work);
    if (has_catchers) {
        find_receivers(scratch, hull, work.canvas, scratch.numbers.rows());
        copy(scratch.receivers.rows(), scratch.numbers.rows(), hull);
    }
    if (!has_movers && work.layer->shadowed != nullptr) keep_receivers(*work.layer->shadowed, scratch, band);
    for (const PixelRect& rect : work.rects) {
        if (lays_picture)
            draw_projected(work, scratch.geometry, scratch.proxies, common(rect, band), scratch.numbers.rows());
        // What movers keep from a layer is found anew in each picture (draw_shadows_of_movers).
        catch_shadows(scratch.geometry, scratch.proxies, !work.shadows.empty() && work.layer == nullptr,
                      common(rect, band), work.canvas, scratch.numbers.rows());
        if (is_matched(work) && triangles.first == scratch.movers.first && triangles.count == scratch.movers.count)
            keep_where_shown(scratch, common(rect, band));
        shade_visible(scratch.geometry, common(rect, band), work.canvas, scratch.numbers, has_movers);
    }
}

void draw_blended(ViewScratch& scratch, std::span<const ViewDraw> draws, ViewWork& work, const PixelRect& band,
                  bool has_movers, AreaBand* areas) {
    // Parts of a pixel that show a film do not know its picture of now: over such, pixels are whole.
    if (areas != nullptr && !work.has_film()) return blend_areas({work, scratch, *areas, band}, draws, has_movers);
    for (const PixelRect& rect : work.rects) {
        for (const ViewDraw& draw : draws)
            blend(scratch.geometry, draw.first_triangle, draw.triangle_count, common(rect, band), work.canvas,
                  has_movers);
    }
}

/// Before what a sensor does.
int light_passes_of(const ViewWork& work) {
    if (work.has_areas) return area_passes;
    return is_matched(work) ? 2 : 1;
}

/// The layer is in the picture: shades anew what of it lies in the shadow of movers.
void draw_shadows_of_movers(ViewWork& work, ViewScratch& scratch, const PixelRect& band) {
    if (work.layer == nullptr || work.layer->shadowed == nullptr) return;
    const ShadowedStatics& statics = *work.layer->shadowed;
    // Its geometry becomes the layer's with the last band of the first picture.
    const ViewGeometry& geometry = work.is_in_parts ? statics.geometry : scratch.geometry;
    const std::uint32_t proxies = work.is_in_parts ? statics.proxies : scratch.proxies;
    for (const PixelRect& rect : work.rects) {
        const PixelRect part = common(rect, band);
        find_shadowed(geometry, part, work.layer->depth_of_shadowed(), statics.numbers.rows(), scratch.numbers.rows());
        catch_shadows(geometry, proxies, true, part, work.canvas, scratch.numbers.rows());
        shade_visible(geometry, part, work.canvas, scratch.numbers);
    }
}

}  // namespace

std::span<const scene::LensView::BlindRun> blind_runs(const scene::LensView& lens, const PixelRect& rect) {
    const std::vector<scene::LensView::BlindRun>& runs = lens.blind();
    const auto first = std::ranges::lower_bound(runs, rect.y0, {}, &scene::LensView::BlindRun::y);
    return {first, std::ranges::lower_bound(runs, rect.y1, {}, &scene::LensView::BlindRun::y)};
}

void cover_blind(const scene::SceneView& view, const Canvas& canvas, const PixelRect& rect) {
    constexpr std::uint32_t black = 0xFFu << 24;
    if (view.lens == nullptr) return;
    for (const auto [y, x0, x1] : blind_runs(*view.lens, rect)) {
        if (canvas.color.data != nullptr) std::fill_n(canvas.color(y) + x0, x1 - x0, black);
        if (canvas.light) fill_light(canvas.light, {x0, y, x1, y + 1}, glm::vec3(0.0f));
        std::fill_n(canvas.depth(y) + x0, x1 - x0, blind_depth);
    }
}

void put_back(ViewWork& work, const PixelRect& band) {
    const StaticLayer& layer = *work.layer;
    const Canvas opaque = layer.picture.canvas();
    const Canvas finished = layer.shown().canvas();
    const Canvas held = work.canvas.light ? work.canvas : Canvas{rows_of(*work.frame), {}, {}};
    if (work.has_film()) {
        for (const PixelRect& rect : work.stale)
            show_picture_below(*work.picture, opaque.color, common(rect, band), held.color);
        for (const PixelRect& rect : work.rects) {
            if (!work.is_in_frame)
                show_picture_below(*work.picture, opaque.color, common(rect, band), work.canvas.color);
            copy(layer.depth.rows(), work.canvas.depth, common(rect, band));
        }
        return;
    }
    for (const PixelRect& rect : work.stale) copy_picture(finished, held, common(rect, band));
    for (const PixelRect& rect : work.rects) {
        if (!work.is_in_frame || layer.finished) copy_picture(opaque, work.canvas, common(rect, band));
        copy(layer.depth.rows(), work.canvas.depth, common(rect, band));
    }
}

void draw_background(ViewWork& work, const PixelRect& rect) {
    const Canvas& canvas = work.canvas;
    const glm::vec3 background = work.scene.background();
    if (is_sampled(work) && canvas.color.data != nullptr) {
        // A projected picture waits for the surfaces that carry it.
        if (work.backdrop->panorama != nullptr) draw_panorama(work, rect);
    } else if (work.backdrop != nullptr && canvas.color.data != nullptr) {
        for (int y = rect.y0; y < rect.y1; ++y)
            std::memcpy(canvas.color(y) + rect.x0, row_of(*work.picture, y) + 4 * rect.x0,
                        static_cast<std::size_t>(rect.width()) * sizeof(std::uint32_t));
        // What is kept tells where that is: the next picture of the film shows there.
        if (work.has_film() && work.layer != nullptr) set_alpha(canvas.color, rect, false);
    } else if (canvas.light) {
        fill_light(canvas.light, rect, background);
    } else {
        fill(canvas.color, rect, pixel_of(background));
    }
    fill(canvas.depth, rect, 0.0f);
    // A plate shows what it shows, also where the lens sees nothing.
    cover_blind(work.scene, work.backdrop != nullptr && !is_sampled(work) ? Canvas{{}, canvas.depth, {}} : canvas,
                rect);
}

void keep_layer(ViewWork& work, ViewScratch& scratch, const PixelRect& band, AreaBand* areas) {
    const Canvas& canvas = work.canvas;
    const StaticLayer& layer = *work.layer;
    copy_picture(canvas, layer.picture.canvas(), band);
    copy(canvas.depth, layer.depth.rows(), band);
    keep_channels(work, band);
    if (work.has_film()) set_alpha(canvas.color, band, true);
    if (!layer.finished) return;
    draw_blended(scratch, scratch.blended_statics, work, band, false, areas);
    copy_picture(canvas, layer.finished.canvas(), band);
    copy_picture(layer.picture.canvas(), canvas, band);
}

void finish_rows(ViewWork& work, ViewScratch& scratch, const PixelRect& band, AreaBand* areas) {
    draw_blended(scratch, scratch.blended, work, band, true, areas);
    // Of a moment surfaces are found beside its rectangles too, and shaded in them alone.
    if (work.is_moment) fill(scratch.numbers.rows(), band, 0u);
    if (work.is_in_frame || work.canvas.light) return;
    for (const PixelRect& rect : work.rects) copy(work.canvas.color, rows_of(*work.frame), common(rect, band));
}

PixelRect drawn_rows(const ViewWork& work) {
    if (!work.is_moment || work.rects.empty()) return work.whole;
    const PixelRect busy = hull_of(work.rects);
    return {work.whole.x0, busy.y0, work.whole.x1, busy.y1};
}

PixelRect band_of(const ViewWork& work, int band, int bands) {
    // The work lies where the rectangles are.
    const PixelRect busy = work.rects.empty() ? work.whole : hull_of(work.rects);
    const PixelRect all = drawn_rows(work);
    const auto row = [&](int i) { return i == 0 ? all.y0 : i == bands ? all.y1 : busy.y0 + busy.height() * i / bands; };
    return {0, row(band), work.whole.x1, row(band + 1)};
}

int passes_of(const ViewWork& work) {
    return light_passes_of(work) + (work.takes_picture() ? 2 : 0);
}

void draw_rows(ViewWork& work, ViewScratch& scratch, int pass, int number, int bands) {
    const PixelRect band = band_of(work, number, bands);
    if (const int taking = pass - light_passes_of(work); taking >= 0)
        return taking == 0 ? expose_rows(work, band) : develop_rows(work, band);
    if (work.has_areas) return draw_area_rows(work, scratch, pass, number, band);
    if (!work.is_shaded()) return draw_channel_rows(work, scratch, band);
    if (pass == 1) {
        match_actors(work, scratch, band);
        return finish_rows(work, scratch, band);
    }
    begin_channels(work, band);
    if (work.is_in_parts) {
        put_back(work, band);
    } else {
        for (const PixelRect& rect : work.rects) draw_background(work, common(rect, band));
        if (work.layer != nullptr) {
            draw_opaque(scratch, scratch.statics, work, band, false);
            keep_layer(work, scratch, band);
        } else if (work.backdrop != nullptr) {
            draw_opaque(scratch, scratch.statics, work, band, true);
        }
    }
    draw_shadows_of_movers(work, scratch, band);
    if (is_matched(work)) keep_below(work, scratch, band);
    draw_opaque(scratch, scratch.movers, work, band, true);
    if (is_matched(work)) return keep_colors(work, scratch, band);
    finish_rows(work, scratch, band);
}

}  // namespace camrig::render::software
