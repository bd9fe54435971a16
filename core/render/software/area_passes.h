#pragma once

#include <bit>
#include <span>

#include "core/render/software/coverage.h"
#include "core/render/software/place_shading.h"
#include "core/render/software/ray_pixels.h"
#include "core/render/software/rows.h"
#include "core/render/software/sample_places.h"
#include "core/render/software/shown_parts.h"
#include "core/render/software/view_rows.h"
#include "core/render/software/view_work.h"

/// The passes of draw_area_rows, and what they share.
namespace camrig::render::software {

/// A band of the rows of a view.
struct RowsOfView {
    ViewWork& work;
    ViewScratch& scratch;
    AreaBand& band;
    const PixelRect& rect;
};

/// Pass 1: which pixels more than one thing that stands still has a part of.
void mark_statics(const RowsOfView& of);
/// Pass 2, of pictures that are drawn in full: those pixels are resolved; with a layer all are shaded, and it is kept.
void draw_statics(const RowsOfView& of);
/// Pass 2, over a layer, which is in the picture: what stands still where the shadows of movers fall on it.
void draw_shadows_of_movers(const RowsOfView& of);
/// Pass 2, at last: what moves, at the middles of pixels, and its outlines.
void find_movers(const RowsOfView& of);
/// Pass 3: which pixels what moves has a part of.
void mark_movers(const RowsOfView& of);
/// Pass 4: those pixels are resolved; all that is not shaded yet is, and blended.
void draw_movers(const RowsOfView& of);

/// What stands still, from the layer if that is in the picture.
inline const StaticPixels& statics_of(const RowsOfView& of) {
    return of.work.is_in_parts ? of.work.layer->areas.pixels : of.band.statics;
}

inline glm::vec3 background_of(const ViewWork& work) {
    const glm::vec3 background = work.scene.background();
    return work.canvas.light ? background : glm::clamp(background, 0.0f, 1.0f);
}

/// Only the steps of a triangle's plane about a pixel: on the screen they are the same everywhere.
inline PixelPlane steps_of(const ViewGeometry& geometry, std::uint32_t triangle, int x, int y) {
    if (geometry.rays() != nullptr)
        return depth_in_pixel(geometry.ray_triangles()[triangle], 0.0f, PixelRay(*geometry.rays(), x, y));
    const Setup s = set_up(geometry.vertices().data(), geometry.triangles()[triangle]);
    return depth_steps(s, depth_plane(s));
}

/// 16 bits each: as floats without their lower half.
inline std::uint32_t packed(const PixelPlane& steps) {
    return std::bit_cast<std::uint32_t>(steps.dx) >> 16 | (std::bit_cast<std::uint32_t>(steps.dy) & 0xFFFF0000u);
}

CAMRIG_LANES std::uint32_t add_place(std::uint32_t triangle, SampleMask mask, int samples, int x, int y,
                                     ShadedPlaces& to) {
    const SampleMean mean = mean_of(mask);
    return to.add({triangle, share_of(samples), x * subpixels + mean.x, y * subpixels + mean.y});
}

/// What a surface has of a pixel, and where it is shaded: at the mean of the places of the largest of its triangles.
struct SurfacePlace {
    SampleMask mask;
    PixelPlane plane;  ///< of that triangle
    std::uint32_t place;
};
CAMRIG_LANES SurfacePlace add_surface(std::span<const Shown> shown, int surface, int x, int y, ShadedPlaces& to) {
    const Shown* largest = nullptr;
    SampleMask mask = 0;
    int most = 0;
    for (const Shown& part : shown) {
        if (part.surface != surface) continue;
        const int count = count_of(part.mask);
        mask |= part.mask;
        if (largest != nullptr && count <= most) continue;
        largest = &part;
        most = count;
    }
    return {mask, largest->plane, add_place(largest->triangle, largest->mask, count_of(mask), x, y, to)};
}

/// What the triangles have of the marked pixels, into the band's fragments; no places are shaded there yet.
inline void collect_fragments(const RowsOfView& of, const TriangleRange& range, const MarkedPixels& marked) {
    of.band.fragments.clear(marked.count());
    of.band.places.clear();
    find_fragments(of.scratch.geometry, range.first, range.count, of.rect, marked, of.band.fragments);
}

/// Puts the band's fragments of a pixel (its index among those that are marked) before and behind the parts that are
/// there, and returns all that shows, each with its surface.
template <typename Isa>
CAMRIG_LANES std::span<Shown> show_fragments(const RowsOfView& of, std::uint32_t pixel, ShownParts& parts) {
    of.band.fragments.each_of(
        pixel, [&](const Fragment& fragment) __attribute__((always_inline)) { parts.add<Isa>(fragment); });
    const std::span<Shown> shown = parts.all();
    find_surfaces(of.scratch.geometry, shown);
    return shown;
}

/// The layer is as if nothing moved: what movers shade is drawn over it in each picture.
inline bool keeps_shadows_apart(const ViewWork& work) {
    return work.layer != nullptr && work.layer->shadowed != nullptr;
}

/// Statics that nothing hides.
inline void add_statics(std::span<const StaticFragment> fragments, MixedPixels& mixed) {
    for (const StaticFragment& fragment : fragments)
        if (fragment.mask != 0) mixed.add(fragment.mask, fragment.plane, fragment.color);
    mixed.end();
}

/// What sees nothing shows nothing but itself; left of it and above, at the end of the lens, rays have no step to the
/// next one (PixelRay), and pixels show what their middles do.
inline void unmark_blind(const RowsOfView& of, MarkedPixels& marked) {
    if (of.work.scene.lens == nullptr) return;
    const PixelRect& rect = of.rect;
    const auto unmark = [&](int y, int x0, int x1) {
        if (y < rect.y0 || y >= rect.y1) return;
        for (int x = std::max(rect.x0, x0); x < x1; ++x) marked.unset(x, y);
    };
    const PixelRect all{rect.x0, rect.y0, rect.x1, rect.y1 + 1};
    for (const auto [y, x0, x1] : blind_runs(*of.work.scene.lens, all)) {
        unmark(y, x0 - 1, x1);
        unmark(y - 1, x0, x1);
    }
}

}  // namespace camrig::render::software
