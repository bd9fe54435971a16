#include <algorithm>

#include "core/render/software/area_passes.h"
#include "core/render/software/catchers.h"
#include "core/render/software/channels.h"
#include "core/render/software/coverage.h"
#include "core/render/software/shading.h"
#include "core/render/software/view_rows.h"

// What moves, by the parts that it has of pixels, over what stands still.
namespace camrig::render::software {
namespace {

PixelPlane plane_of(float z, std::uint32_t steps) {
    return {z, std::bit_cast<float>(steps << 16), std::bit_cast<float>(steps & 0xFFFF0000u)};
}

/// Unmarks pixels whose middle shows a mover that lies before all statics there.
void leave_hidden(const RowsOfView& of, const PixelRect& rect, const StaticPixels& statics, MarkedPixels& outlines) {
    const std::uint32_t last_static = of.scratch.statics.end();
    for (int y = rect.y0; y < rect.y1; ++y) {
        const std::uint32_t* const numbers = of.scratch.numbers.rows()(y);
        const float* const depth = of.work.canvas.depth(y);
        statics.marked.each_of_row(y, [&](int x, int, std::uint32_t) {
            if (x < rect.x0 || x >= rect.x1 || numbers[x] <= last_static) return;
            const auto is_hidden = [&](const StaticFragment& fragment) {
                return fragment.plane.z + fragment.plane.reach() < depth[x] * hidden_below;
            };
            if (std::ranges::all_of(statics.at(x, y), is_hidden)) outlines.unset(x, y);
        });
    }
}

/// What stands still in a marked pixel, as one or more parts.
void show_statics(const RowsOfView& of, std::span<const StaticFragment> fragments, int x, int y, ShownParts& to) {
    for (const StaticFragment& fragment : fragments) {
        if (fragment.mask != 0) {
            Shown& part = to.append(fragment.mask, fragment.plane, fragment.plane.reach());
            part.color = fragment.color;
        }
    }
    if (!fragments.empty()) return;
    Shown& whole = to.append(all_samples, {}, 0.0f);
    if (const StaticLayer* const layer = of.work.layer; layer != nullptr) {
        whole.plane = plane_of(layer->depth.rows()(y)[x], layer->areas.steps.rows()(y)[x]);
        whole.color = shown_by(of.work.canvas, x, y);
    } else {
        const std::uint32_t number = of.scratch.areas.statics_behind.rows()(y)[x];
        whole.plane = plane_of(of.scratch.areas.depth_behind.rows()(y)[x],
                               number == 0 ? 0 : packed(steps_of(of.scratch.geometry, number - 1, x, y)));
        whole.is_behind = true;
    }
    whole.reach = whole.plane.reach();
}

template <typename Isa>
CAMRIG_LANES void resolve_movers_body(const RowsOfView& of) {
    MixedPixels& mixed = of.band.mixed;
    const StaticPixels& statics = statics_of(of);
    const std::uint32_t last_static = of.scratch.statics.end();
    const Rows<std::uint32_t> numbers = of.scratch.numbers.rows();
    ShownParts parts;
    for (int y = of.rect.y0; y < of.rect.y1; ++y) {
        of.band.marked.each_of_row(y, [&](int x, int, std::uint32_t pixel) __attribute__((always_inline)) {
            const std::uint32_t number = numbers(y)[x];
            const bool is_mover = number > last_static;
            const auto fragments = statics.at(x, y);
            if (!is_mover && !of.band.fragments.has(pixel)) {
                // Kept layers have it already.
                if (of.work.layer != nullptr || fragments.empty()) return;
                mixed.begin(x, y);
                add_statics(fragments, mixed);
                return;
            }
            parts.clear();
            show_statics(of, fragments, x, y, parts);
            const std::span<Shown> shown = show_fragments<Isa>(of, pixel, parts);
            if (is_mover && is_as_its_middle(shown, number)) return;
            mixed.begin(x, y);
            for (std::size_t i = 0; i < shown.size(); ++i) {
                const Shown& part = shown[i];
                if (part.surface != static_cast<int>(i)) continue;
                if (part.triangle != no_triangle) {
                    const SurfacePlace made = add_surface(shown, part.surface, x, y, of.band.places);
                    mixed.add_place(made.mask, made.plane, made.place);
                } else if (part.is_behind) {
                    of.scratch.areas.shown_behind.rows()(y)[x] = of.scratch.areas.statics_behind.rows()(y)[x];
                    mixed.add_behind(part.mask, part.plane);
                } else {
                    mixed.add(part.mask, part.plane, part.color);
                }
            }
            mixed.end();
        });
    }
}
CAMRIG_WIDE void resolve_movers_wide(const RowsOfView& of) {
    resolve_movers_body<Avx2Isa>(of);
}

}  // namespace

void find_movers(const RowsOfView& of) {
    const StaticPixels& statics = statics_of(of);
    MarkedPixels& outlines = of.scratch.areas.outlines;
    for (int y = of.rect.y0; y < of.rect.y1; ++y)
        std::copy_n(statics.marked.row(y), statics.marked.words(), outlines.row(y));
    const TriangleRange& range = of.scratch.movers;
    if (range.count == 0 || of.work.rects.empty()) return;
    const PixelRect hull = common(hull_of(of.work.rects), of.rect);
    if (hull.height() <= 0) return;
    find_visible(of.scratch.geometry, range.first, range.count, hull, of.work.canvas, of.scratch.numbers);
    leave_hidden(of, hull, statics, outlines);
    mark_outlines(of.scratch.geometry, range.first, range.count, hull, of.work.canvas.depth, outlines);
}

void mark_movers(const RowsOfView& of) {
    AreaBand& band = of.band;
    band.marked.clear(of.work.whole.width(), of.rect.y0, of.rect.y1);
    const auto mark = [&](const PixelRect& rect) {
        mark_crossings(of.scratch.geometry, common(rect, of.rect), of.scratch.areas.outlines, of.scratch.numbers,
                       of.scratch.statics.end(), band.marked);
    };
    for (const PixelRect& rect : of.work.rects) {
        if (of.work.layer == nullptr) {
            mark(rect);
            continue;
        }
        // What stands still is mixed already, in shadows of movers too.
        for (const PixelRect& mover : of.work.movers.rects) mark(common(mover, rect));
    }
    unmark_blind(of, band.marked);
    band.marked.number();
}

void draw_movers(const RowsOfView& of) {
    AreaBand& band = of.band;
    const ViewGeometry& geometry = of.scratch.geometry;
    collect_fragments(of, of.scratch.movers, band.marked);
    MixedPixels& mixed = band.mixed;
    mixed.clear(background_of(of.work));
    if (geometry.wide_lanes()) {
        resolve_movers_wide(of);
    } else {
        resolve_movers_body<PlainIsa>(of);
    }
    shade_places(geometry, band.places);
    const auto shade = [&](const PixelRect& part, TriangleNumbers& numbers) {
        catch_shadows(geometry, of.scratch.proxies, false, part, of.work.canvas, numbers.rows());
        shade_visible(geometry, part, of.work.canvas, numbers);
    };
    if (of.work.layer == nullptr) {
        // A background behind a mover is in the picture already: nothing is shaded over it yet.
        for (const PixelRect& rect : of.work.movers.rects) shade(common(rect, of.rect), of.scratch.areas.shown_behind);
        mixed.take_behind(of.work.canvas);
    }
    for (const PixelRect& rect : of.work.rects) describe_visible(of.scratch, common(rect, of.rect), of.work);
    mixed.leave_out(of.scratch.numbers.rows());
    for (const PixelRect& rect : of.work.rects) shade(common(rect, of.rect), of.scratch.numbers);
    mixed.mix(band.places, of.work.canvas);
    finish_rows(of.work, of.scratch, of.rect, &of.band);
}

}  // namespace camrig::render::software
