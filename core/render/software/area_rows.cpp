#include "core/render/software/area_rows.h"

#include <algorithm>
#include <cstring>

#include "core/render/software/catchers.h"
#include "core/render/software/channels.h"
#include "core/render/software/coverage.h"
#include "core/render/software/ray_pixels.h"
#include "core/render/software/rows.h"
#include "core/render/software/sample_places.h"
#include "core/render/software/shading.h"
#include "core/render/software/shown_parts.h"
#include "core/render/software/view_rows.h"

namespace camrig::render::software {
namespace {

glm::vec3 background_of(const ViewWork& work) {
    const world::Environment& environment = work.scene.scene->environment();
    const glm::vec3 background = environment.background * environment.exposure;
    return work.canvas.light ? background : glm::clamp(background, 0.0f, 1.0f);
}

/// Only the steps of a triangle's plane about a pixel: on the screen they are the same everywhere.
PixelPlane steps_of(const ViewGeometry& geometry, std::uint32_t triangle, int x, int y) {
    if (geometry.rays() != nullptr)
        return depth_in_pixel(geometry.ray_triangles()[triangle], 0.0f, PixelRay(*geometry.rays(), x, y));
    const Setup s = set_up(geometry.vertices().data(), geometry.triangles()[triangle]);
    return depth_steps(s, depth_plane(s));
}

/// 16 bits each: as floats without their lower half.
std::uint32_t packed(const PixelPlane& steps) {
    return std::bit_cast<std::uint32_t>(steps.dx) >> 16 | (std::bit_cast<std::uint32_t>(steps.dy) & 0xFFFF0000u);
}

PixelPlane plane_of(float z, std::uint32_t steps) {
    return {z, std::bit_cast<float>(steps << 16), std::bit_cast<float>(steps & 0xFFFF0000u)};
}

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

CAMRIG_LANES std::uint32_t add_place(std::uint32_t triangle, SampleMask mask, int samples, int x, int y,
                                     ShadedPlaces& to) {
    const SampleMean mean = mean_of(mask);
    return to.add({triangle, share_of(samples), x * subpixels + mean.x, y * subpixels + mean.y});
}

/// What a surface has of a pixel, and where it is shaded: at the mean of the places of the largest of its triangles.
struct SurfacePlace {
    int samples;
    std::uint32_t place;
};
CAMRIG_LANES SurfacePlace add_surface(std::span<const Shown> shown, int surface, int x, int y, ShadedPlaces& to) {
    const Shown* largest = nullptr;
    int samples = 0, most = 0;
    for (const Shown& part : shown) {
        if (part.surface != surface) continue;
        const int count = count_of(part.mask);
        samples += count;
        if (largest != nullptr && count <= most) continue;
        largest = &part;
        most = count;
    }
    return {samples, add_place(largest->triangle, largest->mask, samples, x, y, to)};
}

struct RowsOfView {
    ViewWork& work;
    ViewScratch& scratch;
    AreaBand& band;
    const PixelRect& rect;
};

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
    band.fragments.each_of(band.crowded.index_of(x, y),
                           [&](const Fragment& fragment) __attribute__((always_inline)) { parts.add<Isa>(fragment); });
    const std::span<Shown> shown = parts.all();
    find_surfaces(of.scratch.geometry, shown);
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

bool is_light(const RowsOfView& of) {
    return static_cast<bool>(of.work.canvas.light);
}

/// The layer is as if nothing moved: what movers shade is drawn over it in each picture.
bool keeps_shadows_apart(const ViewWork& work) {
    return work.layer != nullptr && work.layer->shadowed != nullptr;
}

void shade_static_fragments(const RowsOfView& of) {
    StaticPixels& statics = of.band.statics;
    const bool is_apart = keeps_shadows_apart(of.work);
    shade_places(of.scratch.geometry, {.is_light = is_light(of), .has_movers = !is_apart}, of.band.places);
    for (std::size_t i = 0; i < of.band.place_of_fragment.size(); ++i) {
        const std::uint32_t place = of.band.place_of_fragment[i];
        if (place != no_place) statics.fragments[i].color = of.band.places.colors[place];
    }
    if (!is_apart) return;
    statics.places = of.band.places.places;
    statics.place_of_fragment = of.band.place_of_fragment;
    for (const StaticFragment& fragment : statics.fragments) statics.lit_colors.push_back(fragment.color);
}

/// Statics that nothing hides.
void add_statics(std::span<const StaticFragment> fragments, MixedPixels& mixed) {
    for (const StaticFragment& fragment : fragments) {
        const int samples = count_of(fragment.mask);
        if (samples > 0) mixed.add(samples, fragment.color);
    }
    mixed.end();
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
    mixed.leave_out(numbers);
    catch_shadows(of.scratch.geometry, of.scratch.proxies, false, of.rect, of.work.canvas, numbers);
    // What is mixed is shaded part by part, but shadows on the picture of a backdrop are those at the middle.
    for (int y = of.rect.y0; is_apart && y < of.rect.y1; ++y)
        for (int x = of.rect.x0; x < of.rect.x1; ++x)
            if (kept(y)[x] > of.scratch.proxies) kept(y)[x] = numbers(y)[x];
    shade_visible(of.scratch.geometry, of.rect, of.work.canvas, of.scratch.numbers, !is_apart);
    mixed.mix(of.band.places, of.work.canvas);
}

/// Calls visit(x, y, first, end) for the layer's marked pixels in the rectangles, and their fragments.
template <typename Visit>
void each_static_pixel(const RowsOfView& of, const StaticPixels& statics, const Visit& visit) {
    for (const PixelRect& rect : of.work.rects) {
        const PixelRect part = common(rect, of.rect);
        for (int y = part.y0; y < part.y1; ++y)
            statics.marked.each_of_row(y, [&](int x, int, std::uint32_t pixel) {
                if (x >= part.x0 && x < part.x1) visit(x, y, statics.first[pixel], statics.first[pixel + 1]);
            });
    }
}

/// A fragment that shows the picture of a backdrop.
bool is_of_picture(const RowsOfView& of, const StaticPixels& statics, std::uint32_t fragment) {
    return of.work.backdrop != nullptr && statics.place_of_fragment[fragment] == no_place;
}

/// What the picture of a backdrop has at a pixel, of which a fragment knows the light.
std::uint32_t pixel_of_picture(const RowsOfView& of, const glm::vec3& light, int x, int y) {
    if (of.work.backdrop->panorama != nullptr) return pixel_of(light);
    const world::Image& picture = *of.work.picture;
    std::uint32_t pixel = 0;
    std::memcpy(&pixel, picture.rgba.data() + std::size_t{4} * static_cast<std::size_t>(y * picture.size.width + x),
                sizeof pixel);
    return pixel;
}

/// The layer's fragments in the rectangles, as if nothing moved; of pixels that show something of the picture of a
/// backdrop, the canvas has its colour, for shadows to darken.
void take_out_shadows(const RowsOfView& of, StaticPixels& statics) {
    each_static_pixel(of, statics, [&](int x, int y, std::uint32_t first, std::uint32_t end) {
        for (std::uint32_t i = first; i < end; ++i) {
            statics.fragments[i].color = statics.lit_colors[i];
            if (is_of_picture(of, statics, i))
                of.work.canvas.color(y)[x] = pixel_of_picture(of, statics.lit_colors[i], x, y);
        }
    });
}

/// The fragments in the rectangles that movers may shade.
void find_shadowed_fragments(const RowsOfView& of, const ViewGeometry& geometry, const StaticPixels& statics) {
    AreaBand& band = of.band;
    band.places.clear();
    band.fragment_of_place.clear();
    each_static_pixel(of, statics, [&](int, int, std::uint32_t first, std::uint32_t end) {
        for (std::uint32_t i = first; i < end; ++i) {
            if (statics.place_of_fragment[i] == no_place) continue;
            band.places.add(statics.places[statics.place_of_fragment[i]]);
            band.fragment_of_place.push_back(i);
        }
    });
    band.is_shadowed.resize(band.places.places.size());
    find_shadowed(geometry, band.places.places, band.is_shadowed);
    std::size_t left = 0;
    for (std::size_t i = 0; i < band.is_shadowed.size(); ++i) {
        if (band.is_shadowed[i] == 0) continue;
        band.places.places[left] = band.places.places[i];
        band.fragment_of_place[left++] = band.fragment_of_place[i];
    }
    band.places.places.resize(left);
    band.fragment_of_place.resize(left);
}

/// Over the layer, which is in the picture: what stands still where the shadows of movers fall on it.
void draw_shadows_of_movers(const RowsOfView& of) {
    if (!keeps_shadows_apart(of.work)) return;
    const StaticLayer& layer = *of.work.layer;
    AreaBand& band = of.band;
    // Its geometry and pixels become the layer's with the last band of the first picture.
    const ViewGeometry& geometry = of.work.is_in_parts ? layer.shadowed->geometry : of.scratch.geometry;
    const std::uint32_t proxies = of.work.is_in_parts ? layer.shadowed->proxies : of.scratch.proxies;
    StaticPixels& statics = of.work.is_in_parts ? of.work.layer->areas.pixels : band.statics;
    take_out_shadows(of, statics);
    for (const PixelRect& rect : of.work.rects) {
        const PixelRect part = common(rect, of.rect);
        find_shadowed(geometry, part, layer.depth.rows(), layer.shadowed->numbers.rows(), of.scratch.numbers.rows());
        catch_shadows(geometry, proxies, true, part, of.work.canvas, of.scratch.numbers.rows());
        shade_visible(geometry, part, of.work.canvas, of.scratch.numbers);
    }
    find_shadowed_fragments(of, geometry, statics);
    shade_places(geometry, {.is_light = is_light(of)}, band.places);
    for (std::size_t i = 0; i < band.fragment_of_place.size(); ++i)
        statics.fragments[band.fragment_of_place[i]].color = band.places.colors[i];
    MixedPixels& mixed = band.mixed;
    mixed.clear(background_of(of.work));
    each_static_pixel(of, statics, [&](int x, int y, std::uint32_t first, std::uint32_t end) {
        bool has_picture = false, is_other = false;
        for (std::uint32_t i = first; i < end; ++i) {
            const bool is_picture = is_of_picture(of, statics, i);
            if (is_picture) statics.fragments[i].color = linear_of(of.work.canvas.color(y)[x]);
            has_picture |= is_picture;
            is_other |= statics.fragments[i].color != statics.lit_colors[i];
        }
        if (has_picture && !is_other) of.work.canvas.color(y)[x] = layer.picture.color.rows()(y)[x];
        if (!is_other) return;
        mixed.begin(x, y);
        add_statics(std::span(statics.fragments).subspan(first, end - first), mixed);
    });
    mixed.mix(band.places, of.work.canvas);
}

/// Remembers what stands still where movers will be drawn over it.
void keep_behind(const RowsOfView& of) {
    for (const PixelRect& rect : of.work.movers.rects) {
        const PixelRect part = common(rect, of.rect);
        copy(of.scratch.numbers.rows(), of.scratch.areas.statics_behind.rows(), part);
        copy(of.work.canvas.depth, of.scratch.areas.depth_behind.rows(), part);
    }
}

/// What sees nothing shows nothing but itself; left of it and above, at the end of the lens, rays have no step to the
/// next one (PixelRay), and pixels show what their middles do.
void unmark_blind(const RowsOfView& of, MarkedPixels& marked) {
    if (of.work.scene.lens == nullptr) return;
    const PixelRect& rect = of.rect;
    const auto unmark = [&](int y, int x0, int x1) {
        if (y < rect.y0 || y >= rect.y1) return;
        for (int x = std::max(rect.x0, x0); x < x1; ++x) marked.unset(x, y);
    };
    for (const auto [y, x0, x1] : blind_runs(*of.work.scene.lens, {rect.x0, rect.y0, rect.x1, rect.y1 + 1})) {
        unmark(y, x0 - 1, x1);
        unmark(y - 1, x0, x1);
    }
}

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
    const ViewGeometry& geometry = of.scratch.geometry;
    const TriangleRange& range = of.scratch.statics;
    band.fragments.clear(band.crowded.count());
    band.places.clear();
    band.place_of_fragment.clear();
    find_fragments(geometry, range.first, range.count, of.rect, band.crowded, band.fragments);
    if (geometry.wide_lanes()) {
        resolve_statics_wide(of);
    } else {
        resolve_statics_body<PlainIsa>(of);
    }
    shade_static_fragments(of);
    if (of.work.layer == nullptr) return keep_behind(of);
    draw_static_pixels(of);
    keep_layer(of.work, of.scratch, of.rect);
}

/// Unmarks pixels whose middle shows a mover that lies before all statics there.
void leave_hidden(const RowsOfView& of, const PixelRect& rect, const StaticPixels& statics, MarkedPixels& outlines) {
    const std::uint32_t last_static = of.scratch.statics.count;
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

void find_movers(const RowsOfView& of) {
    const StaticPixels& statics = of.work.is_in_parts ? of.work.layer->areas.pixels : of.band.statics;
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
    const ViewGeometry& geometry = of.scratch.geometry;
    const StaticPixels& statics = of.work.is_in_parts ? of.work.layer->areas.pixels : of.band.statics;
    const std::uint32_t last_static = of.scratch.statics.count;
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
            of.band.fragments.each_of(
                pixel, [&](const Fragment& fragment) __attribute__((always_inline)) { parts.add<Isa>(fragment); });
            const std::span<Shown> shown = parts.all();
            find_surfaces(geometry, shown);
            if (is_mover && is_as_its_middle(shown, number)) return;
            mixed.begin(x, y);
            for (std::size_t i = 0; i < shown.size(); ++i) {
                const Shown& part = shown[i];
                if (part.surface != static_cast<int>(i)) continue;
                if (part.triangle != no_triangle) {
                    const SurfacePlace made = add_surface(shown, part.surface, x, y, of.band.places);
                    mixed.add_place(made.samples, made.place);
                } else if (part.is_behind) {
                    of.scratch.areas.shown_behind.rows()(y)[x] = of.scratch.areas.statics_behind.rows()(y)[x];
                    mixed.add_behind(count_of(part.mask));
                } else {
                    mixed.add(count_of(part.mask), part.color);
                }
            }
            mixed.end();
        });
    }
}
CAMRIG_WIDE void resolve_movers_wide(const RowsOfView& of) {
    resolve_movers_body<Avx2Isa>(of);
}

void mark_movers(const RowsOfView& of) {
    AreaBand& band = of.band;
    band.marked.clear(of.work.whole.width(), of.rect.y0, of.rect.y1);
    const auto mark = [&](const PixelRect& rect) {
        mark_crossings(of.scratch.geometry, common(rect, of.rect), of.scratch.areas.outlines, of.scratch.numbers,
                       of.scratch.statics.count, band.marked);
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
    const TriangleRange& range = of.scratch.movers;
    band.fragments.clear(band.marked.count());
    band.places.clear();
    find_fragments(geometry, range.first, range.count, of.rect, band.marked, band.fragments);
    MixedPixels& mixed = band.mixed;
    mixed.clear(background_of(of.work));
    if (geometry.wide_lanes()) {
        resolve_movers_wide(of);
    } else {
        resolve_movers_body<PlainIsa>(of);
    }
    shade_places(geometry, {.is_light = is_light(of)}, band.places);
    if (of.work.layer == nullptr) {
        // A background behind a mover is in the picture already: nothing is shaded over it yet.
        for (const PixelRect& rect : of.work.movers.rects) {
            const PixelRect part = common(rect, of.rect);
            catch_shadows(geometry, of.scratch.proxies, false, part, of.work.canvas,
                          of.scratch.areas.shown_behind.rows());
            shade_visible(geometry, part, of.work.canvas, of.scratch.areas.shown_behind);
        }
        mixed.take_behind(of.work.canvas);
    }
    for (const PixelRect& rect : of.work.rects) describe_visible(of.scratch, common(rect, of.rect), of.work);
    mixed.leave_out(of.scratch.numbers.rows());
    for (const PixelRect& rect : of.work.rects) {
        const PixelRect part = common(rect, of.rect);
        catch_shadows(geometry, of.scratch.proxies, false, part, of.work.canvas, of.scratch.numbers.rows());
        shade_visible(geometry, part, of.work.canvas, of.scratch.numbers);
    }
    mixed.mix(band.places, of.work.canvas);
    finish_rows(of.work, of.scratch, of.rect);
}

}  // namespace

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
            if (!work.shadows.empty() && work.layer == nullptr)
                darken_proxies(scratch.geometry, scratch.proxies, rect, work.canvas, scratch.numbers.rows());
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
