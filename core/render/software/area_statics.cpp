#include "core/render/software/area_passes.h"
#include "core/render/software/catchers.h"
#include "core/render/software/channels.h"
#include "core/render/software/coverage.h"
#include "core/render/software/divided_pixels.h"
#include "core/render/software/shading.h"
#include "core/render/software/view_rows.h"

// What stands still, by the parts that it has of pixels: marked, resolved, shaded, kept in a layer.
namespace camrig::render::software {
namespace {

/// That of a triangle about a pixel.
CAMRIG_LANES PixelPlane plane_at(const ViewGeometry& geometry, std::uint32_t triangle, int x, int y) {
    const Setup s = set_up(geometry.vertices().data(), geometry.triangles()[triangle]);
    const DepthPlane depth = depth_plane(s);
    PixelPlane plane = depth_steps(s, depth);
    const std::int64_t px = std::int64_t{x} * subpixels, py = std::int64_t{y} * subpixels;
    plane.z = static_cast<float>(depth.base + static_cast<double>(edge(s, 1, px, py)) * depth.second +
                                 static_cast<double>(edge(s, 2, px, py)) * depth.third);
    return plane;
}

bool is_proxy(const RowsOfView& of, std::uint32_t triangle) {
    return triangle < of.scratch.proxies;
}

/// A part of a static pixel that shows the picture of a backdrop.
CAMRIG_LANES void add_picture(const RowsOfView& of, SampleMask mask, const PixelPlane& plane, int x, int y) {
    StaticFragment& made = of.band.statics.fragments.emplace_back();
    made.mask = mask;
    made.plane = plane;
    made.color = linear_of(of.work.canvas.color(y)[x]);
    of.band.place_of_fragment.push_back(no_place);
}

/// A part of a static pixel; place: of its colour.
CAMRIG_LANES void add_static(AreaBand& band, SampleMask mask, const PixelPlane& plane, std::uint32_t place) {
    StaticFragment& made = band.statics.fragments.emplace_back();
    made.mask = mask;
    made.plane = plane;
    band.place_of_fragment.push_back(place);
}

template <typename Isa>
CAMRIG_LANES void add_crowded(const RowsOfView& of, int x, int y, ShownParts& parts) {
    AreaBand& band = of.band;
    const std::uint32_t number = of.scratch.numbers.rows()(y)[x];
    parts.clear();
    const std::span<Shown> shown = show_fragments<Isa>(of, band.crowded.index_of(x, y), parts);
    if (is_as_its_middle(shown, number)) return;
    if (shown.empty() && of.work.backdrop == nullptr) add_static(band, 0, {}, no_place);
    const auto first = band.place_of_fragment.size();
    SampleMask uncovered = all_samples;
    for (std::size_t i = 0; i < shown.size(); ++i) {
        uncovered &= ~shown[i].mask;
        if (is_proxy(of, shown[i].triangle)) {
            add_picture(of, shown[i].mask, shown[i].plane, x, y);
            continue;
        }
        const auto surface = static_cast<std::size_t>(shown[i].surface);
        add_static(band, shown[i].mask, shown[i].plane,
                   surface != i ? band.place_of_fragment[first + surface]
                                : add_surface(shown, shown[i].surface, x, y, band.places).place);
    }
    if (of.work.backdrop != nullptr && uncovered != 0) add_picture(of, uncovered, {}, x, y);
}

CAMRIG_LANES void add_divided(const RowsOfView& of, int x, int y, const DividedPixel& pixel) {
    if (pixel.mask == all_samples) return;
    const ViewGeometry& geometry = of.scratch.geometry;
    const auto add = [&](std::uint32_t number, SampleMask mask) {
        if (number == 0 && of.work.backdrop != nullptr) return add_picture(of, mask, {}, x, y);
        if (number == 0) return;
        if (is_proxy(of, number - 1)) return add_picture(of, mask, plane_at(geometry, number - 1, x, y), x, y);
        add_static(of.band, mask, plane_at(geometry, number - 1, x, y),
                   add_place(number - 1, mask, count_of(mask), x, y, of.band.places));
    };
    add(of.scratch.numbers.rows()(y)[x], pixel.mask);
    add(pixel.other, ~pixel.mask);
}

template <typename Isa>
CAMRIG_LANES void resolve_statics_body(const RowsOfView& of) {
    StaticPixels& statics = of.band.statics;
    auto divided = of.band.divided.begin();
    ShownParts parts;
    for (int y = of.rect.y0; y < of.rect.y1; ++y) {
        statics.marked.each_of_row(y, [&](int x, int, std::uint32_t) __attribute__((always_inline)) {
            if (of.band.crowded.has(x, y)) {
                add_crowded<Isa>(of, x, y, parts);
            } else {
                add_divided(of, x, y, *divided++);
            }
            statics.first.push_back(static_cast<std::uint32_t>(statics.fragments.size()));
        });
    }
}
CAMRIG_WIDE void resolve_statics_wide(const RowsOfView& of) {
    resolve_statics_body<Avx2Isa>(of);
}

void shade_static_fragments(const RowsOfView& of) {
    StaticPixels& statics = of.band.statics;
    const bool is_apart = keeps_shadows_apart(of.work);
    shade_places(of.scratch.geometry, of.band.places, !is_apart);
    for (std::size_t i = 0; i < of.band.place_of_fragment.size(); ++i) {
        const std::uint32_t place = of.band.place_of_fragment[i];
        if (place != no_place) statics.fragments[i].color = of.band.places.colors[place];
    }
    if (!is_apart) return;
    statics.places = of.band.places.places;
    statics.positions = positions_of(of.scratch.geometry, statics.places);
    statics.place_of_fragment = of.band.place_of_fragment;
    for (const StaticFragment& fragment : statics.fragments) statics.lit_colors.push_back(fragment.color);
}

/// The statics of a picture whose layer is kept.
void draw_static_pixels(const RowsOfView& of) {
    const StaticPixels& statics = of.band.statics;
    const Rows<std::uint32_t> numbers = of.scratch.numbers.rows(), steps = of.work.layer->areas.steps.rows();
    const bool has_rays = of.scratch.geometry.rays() != nullptr;
    for (int y = of.rect.y0; y < of.rect.y1; ++y) {
        std::uint32_t last = 0, made = 0;
        for (int x = of.rect.x0; x < of.rect.x1; ++x) {
            const std::uint32_t number = numbers(y)[x];
            if (number != last || has_rays)
                made = number == 0 ? 0 : packed(steps_of(of.scratch.geometry, number - 1, x, y));
            last = number;
            steps(y)[x] = made;
        }
    }
    MixedPixels& mixed = of.band.mixed;
    mixed.clear(background_of(of.work));
    for (int y = of.rect.y0; y < of.rect.y1; ++y) {
        statics.marked.each_of_row(y, [&](int x, int, std::uint32_t) {
            const auto fragments = statics.at(x, y);
            if (fragments.empty()) return;
            mixed.begin(x, y);
            add_statics(fragments, mixed);
        });
    }
    describe_visible(of.scratch, of.rect, of.work);
    const bool is_apart = keeps_shadows_apart(of.work);
    const Rows<std::uint32_t> kept = is_apart ? of.work.layer->shadowed->numbers.rows() : Rows<std::uint32_t>{};
    if (is_apart) copy(numbers, kept, of.rect);
    if (is_apart && of.scratch.catchers > 0) {
        find_receivers(of.scratch, of.rect, of.work.canvas, numbers);
        copy(of.scratch.receivers.rows(), kept, of.rect);
        copy(of.scratch.receiver_depth.rows(), of.work.layer->shadowed->depth.rows(), of.rect);
    }
    mixed.leave_out(numbers);
    catch_shadows(of.scratch.geometry, of.scratch.proxies, false, of.rect, of.work.canvas, numbers);
    // What is mixed is shaded part by part, but shadows on the picture of a backdrop are those at the middle.
    for (int y = of.rect.y0; is_apart && y < of.rect.y1; ++y)
        for (int x = of.rect.x0; x < of.rect.x1; ++x)
            if (kept(y)[x] > of.scratch.proxies) kept(y)[x] = numbers(y)[x];
    shade_visible(of.scratch.geometry, of.rect, of.work.canvas, of.scratch.numbers, !is_apart);
    mixed.mix(of.band.places, of.work.canvas);
}

/// Remembers what stands still where movers will be drawn over it.
void keep_behind(const RowsOfView& of) {
    for (const PixelRect& rect : of.work.movers.rects) {
        const PixelRect part = common(rect, of.rect);
        copy(of.scratch.numbers.rows(), of.scratch.areas.statics_behind.rows(), part);
        copy(of.work.canvas.depth, of.scratch.areas.depth_behind.rows(), part);
    }
}

}  // namespace

void mark_statics(const RowsOfView& of) {
    AreaBand& band = of.band;
    band.statics.clear(of.work.whole.width(), of.rect.y0, of.rect.y1);
    mark_crossings(of.scratch.geometry, of.rect, of.scratch.areas.outlines, of.scratch.numbers, 0, band.statics.marked);
    unmark_blind(of, band.statics.marked);
    band.statics.marked.number();
    band.crowded.clear(of.work.whole.width(), of.rect.y0, of.rect.y1);
    band.divided.clear();
    find_divided(of.scratch.geometry, of.rect, drawn_rows(of.work), band.statics.marked, of.scratch.areas.edges,
                 of.scratch.numbers.rows(), of.work.canvas.depth, band.crowded, band.divided);
    band.crowded.number();
}

void draw_statics(const RowsOfView& of) {
    AreaBand& band = of.band;
    collect_fragments(of, of.scratch.statics, band.crowded);
    band.place_of_fragment.clear();
    if (of.scratch.geometry.wide_lanes()) {
        resolve_statics_wide(of);
    } else {
        resolve_statics_body<PlainIsa>(of);
    }
    shade_static_fragments(of);
    if (of.work.layer == nullptr) return keep_behind(of);
    draw_static_pixels(of);
    keep_layer(of.work, of.scratch, of.rect, &of.band);
}

}  // namespace camrig::render::software
