#include "core/render/software/area_rows.h"

#include "core/render/software/area_passes.h"
#include "core/render/software/catchers.h"
#include "core/render/software/channels.h"
#include "core/render/software/view_rows.h"

namespace camrig::render::software {

void draw_area_rows(ViewWork& work, ViewScratch& scratch, int pass, int number, const PixelRect& rect) {
    const RowsOfView of{work, scratch, scratch.areas.bands[static_cast<std::size_t>(number)], rect};
    if (pass == 0) begin_channels(work, rect);
    if (work.is_in_parts && pass < 2) {
        if (pass == 0) put_back(work, rect);
        return;
    }
    switch (pass) {
        case 0: {
            draw_background(work, rect);
            const TriangleRange& range = scratch.statics;
            find_visible(scratch.geometry, range.first, range.count, rect, work.canvas, scratch.numbers);
            if (!work.shadows.empty() && work.layer == nullptr) {
                const bool has_catchers = scratch.catchers > 0;
                if (has_catchers) find_receivers(scratch, rect, work.canvas, scratch.numbers.rows());
                darken_proxies(scratch.geometry, scratch.proxies, rect, work.canvas,
                               (has_catchers ? scratch.receivers : scratch.numbers).rows());
            }
            scratch.areas.edges.clear(rect);
            return mark_outlines(scratch.geometry, range.first, range.count, rect, work.canvas.depth,
                                 scratch.areas.outlines, &scratch.areas.edges);
        }
        case 1:
            return mark_statics(of);
        case 2:
            if (!work.is_in_parts) draw_statics(of);
            draw_shadows_of_movers(of);
            return find_movers(of);
        case 3:
            return mark_movers(of);
        default:
            return draw_movers(of);
    }
}

}  // namespace camrig::render::software
