#include <cstring>

#include "core/render/software/area_passes.h"
#include "core/render/software/catchers.h"
#include "core/render/software/shading.h"

// What a layer keeps of parts of pixels, where the shadows of what moves fall on them.
namespace camrig::render::software {
namespace {

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

/// The layer's fragments in the rectangles, as if nothing moved, which the band has then; of pixels that show something
/// of the picture of a backdrop, the canvas has its colour, for shadows to darken.
void take_out_shadows(const RowsOfView& of, StaticPixels& statics) {
    AreaBand& band = of.band;
    band.fragment_of_place.clear();
    band.positions.clear();
    each_static_pixel(of, statics, [&](int x, int y, std::uint32_t first, std::uint32_t end) {
        for (std::uint32_t i = first; i < end; ++i) {
            statics.fragments[i].color = statics.lit_colors[i];
            if (is_of_picture(of, statics, i))
                of.work.canvas.color(y)[x] = pixel_of_picture(of, statics.lit_colors[i], x, y);
            if (statics.place_of_fragment[i] == no_place) continue;
            band.fragment_of_place.push_back(i);
            band.positions.push_back(statics.positions[statics.place_of_fragment[i]]);
        }
    });
}

/// Those of the band's fragments that movers may shade.
void find_shadowed_fragments(const RowsOfView& of, const ViewGeometry& geometry, const StaticPixels& statics) {
    AreaBand& band = of.band;
    band.places.clear();
    band.is_shadowed.resize(band.positions.size());
    find_shadowed(geometry, band.positions, band.is_shadowed);
    for (std::size_t i = 0; i < band.is_shadowed.size(); ++i) {
        if (band.is_shadowed[i] == 0) continue;
        const std::uint32_t fragment = band.fragment_of_place[i];
        band.fragment_of_place[band.places.add(statics.places[statics.place_of_fragment[fragment]])] = fragment;
    }
    band.fragment_of_place.resize(band.places.places.size());
}

}  // namespace

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
        find_shadowed(geometry, part, layer.depth_of_shadowed(), layer.shadowed->numbers.rows(),
                      of.scratch.numbers.rows());
        catch_shadows(geometry, proxies, true, part, of.work.canvas, of.scratch.numbers.rows());
        shade_visible(geometry, part, of.work.canvas, of.scratch.numbers);
    }
    find_shadowed_fragments(of, geometry, statics);
    shade_places(geometry, band.places);
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

}  // namespace camrig::render::software
