#include "core/render/software/blended_areas.h"

namespace camrig::render::software {
namespace {

/// What of the pixels of a band is opaque, asked for from left to right and top to bottom.
class OpaqueParts {
public:
    explicit OpaqueParts(const RowsOfView& of) : of_(of), statics_(statics_of(of)) {}

    /// Whether nothing that moves has a part of a pixel of which a layer keeps several.
    bool shows_layer(int x, int y) const {
        const StaticLayer* const layer = of_.work.layer;
        return layer != nullptr && !statics_.at(x, y).empty() &&
               of_.work.canvas.depth(y)[x] == layer->depth.rows()(y)[x];
    }

    /// The parts of a pixel. True: it shows one surface, whose depth is known at its middle alone.
    bool at(int x, int y, std::vector<StaticFragment>& to) {
        to.clear();
        const std::span<const MixedPixels::Pixel> pixels = of_.band.mixed.pixels();
        const auto is_before = [&](const MixedPixels::Pixel& pixel) {
            return pixel.y < y || (pixel.y == y && pixel.x < x);
        };
        while (next_ < pixels.size() && is_before(pixels[next_])) ++next_;
        if (next_ < pixels.size() && pixels[next_].x == x && pixels[next_].y == y) {
            for (const MixedPixels::Part& part : of_.band.mixed.parts_of(next_))
                to.push_back({part.mask, part.plane, MixedPixels::color_of(part, of_.band.places)});
            return false;
        }
        if (shows_layer(x, y)) {
            SampleMask left = all_samples;
            for (const StaticFragment& fragment : statics_.at(x, y)) {
                if (fragment.mask != 0) to.push_back(fragment);
                left &= ~fragment.mask;
            }
            if (left != 0) to.push_back({left, {}, background_of(of_.work)});
            return false;
        }
        to.push_back({all_samples, {of_.work.canvas.depth(y)[x]}, shown_by(of_.work.canvas, x, y)});
        return true;
    }

private:
    const RowsOfView& of_;
    const StaticPixels& statics_;
    std::size_t next_ = 0;  ///< among the pixels of `mixed`
};

/// Where a fragment lies in front of a part.
template <typename Isa>
CAMRIG_LANES SampleMask in_front_of(const Fragment& fragment, const StaticFragment& part, bool is_whole) {
    if (is_whole) return fragment.plane.z > part.plane.z ? all_samples : 0;
    return in_front<Isa>(fragment.plane, part.plane, fragment.reach + part.plane.reach());
}

/// A contact shadow ends in nothing: where only such are, pixels stay whole.
bool is_soft(const ViewDraw& draw) {
    return draw.placed->is_contact_shadow;
}

void find_fragments_of(const RowsOfView& of, std::span<const ViewDraw> draws, bool with_soft,
                       const MarkedPixels& marked, PixelFragments& to) {
    to.clear(marked.count());
    for (const ViewDraw& draw : draws)
        if (with_soft || !is_soft(draw))
            find_fragments(of.scratch.geometry, draw.first_triangle, draw.triangle_count, of.rect, marked, to);
}

/// Which pixels may be blended part by part.
void mark_parts(const RowsOfView& of, std::span<const ViewDraw> draws, MarkedPixels& to) {
    to.clear(of.work.whole.width(), of.rect.y0, of.rect.y1);
    const OpaqueParts opaque(of);
    const StaticPixels& statics = statics_of(of);
    for (const PixelRect& rect : of.work.rects) {
        const PixelRect part = common(rect, of.rect);
        for (const ViewDraw& draw : draws)
            if (!is_soft(draw))
                mark_outlines(of.scratch.geometry, draw.first_triangle, draw.triangle_count, part, of.work.canvas.depth,
                              to);
        for (int y = part.y0; y < part.y1 && of.work.layer != nullptr; ++y) {
            statics.marked.each_between(y, part.x0, part.x1, [&](int x, int) {
                if (opaque.shows_layer(x, y)) to.set(x, y);
            });
        }
    }
    for (const MixedPixels::Pixel& pixel : of.band.mixed.pixels()) to.set(pixel.x, pixel.y);
    unmark_blind(of, to);
    to.number();
}

/// Which pixels are blended part by part, and what covers these.
void find_blended(const RowsOfView& of, std::span<const ViewDraw> draws) {
    BlendedPixels& blended = of.band.blended;
    blended.clear();
    mark_parts(of, draws, blended.marked);
    find_fragments_of(of, draws, false, blended.marked, blended.fragments);
    if (std::ranges::none_of(draws, is_soft)) return;
    for (int y = of.rect.y0; y < of.rect.y1; ++y) {
        blended.marked.each_of_row(y, [&](int x, int, std::uint32_t pixel) {
            if (!blended.fragments.has(pixel)) blended.marked.unset(x, y);
        });
    }
    blended.marked.number();
    find_fragments_of(of, draws, true, blended.marked, blended.fragments);
}

/// The parts of the marked pixels, and what covers them.
template <typename Isa>
CAMRIG_LANES void find_covered_body(const RowsOfView& of) {
    BlendedPixels& blended = of.band.blended;
    std::vector<StaticFragment>& parts = blended.of_pixel;
    OpaqueParts opaque(of);
    for (int y = of.rect.y0; y < of.rect.y1; ++y) {
        blended.marked.each_of_row(y, [&](int x, int, std::uint32_t pixel) __attribute__((always_inline)) {
            if (!blended.fragments.has(pixel)) return;
            // So much is blended over the whole pixel.
            if (blended.fragments.is_full(pixel)) return blended.marked.unset(x, y);
            const bool is_whole = opaque.at(x, y, parts);
            const auto first_part = static_cast<std::uint32_t>(blended.parts.size());
            const std::size_t first_cover = blended.covers.size();
            blended.fragments.each_of(pixel, [&](const Fragment& fragment) __attribute__((always_inline)) {
                std::uint32_t place = no_place;
                for (std::size_t i = 0, count = parts.size(); i < count; ++i) {
                    const StaticFragment part = parts[i];  // a copy: there will be more
                    const SampleMask mask = part.mask & fragment.mask & in_front_of<Isa>(fragment, part, is_whole);
                    if (mask == 0) continue;
                    if (place == no_place)
                        place =
                            add_place(fragment.triangle, fragment.mask, count_of(fragment.mask), x, y, blended.places);
                    // Some of it is a part of its own from here on.
                    const bool is_all = mask == part.mask;
                    const std::size_t made = is_all ? i : parts.size();
                    blended.covers.push_back({place, first_part + static_cast<std::uint32_t>(i),
                                              first_part + static_cast<std::uint32_t>(made)});
                    if (is_all) continue;
                    parts[i].mask &= ~mask;
                    parts.push_back({mask, part.plane, {}});
                }
            });
            if (blended.covers.size() == first_cover) return;
            for (const StaticFragment& part : parts)
                blended.parts.push_back({share_of(count_of(part.mask)), part.color});
            blended.pixels.push_back({x, y, first_part});
        });
    }
}
CAMRIG_WIDE void find_covered_wide(const RowsOfView& of) {
    find_covered_body<Avx2Isa>(of);
}

void blend_parts(BlendedPixels& of, MixedPixels& to) {
    for (const auto& [place, from, made] : of.covers)
        of.parts[made].color = of.places.colors[place] + of.places.through[place] * of.parts[from].color;
    for (std::size_t i = 0; i < of.pixels.size(); ++i) {
        const BlendedPixels::Pixel& pixel = of.pixels[i];
        const std::size_t end = i + 1 < of.pixels.size() ? of.pixels[i + 1].first_part : of.parts.size();
        glm::vec3 sum(0.0f);
        for (std::size_t k = pixel.first_part; k < end; ++k) sum += of.parts[k].share * of.parts[k].color;
        to.begin(pixel.x, pixel.y);
        to.add(all_samples, {}, sum);
    }
}

}  // namespace

void blend_areas(const RowsOfView& of, std::span<const ViewDraw> draws, bool has_movers) {
    if (draws.empty() || of.work.rects.empty()) return;
    const ViewGeometry& geometry = of.scratch.geometry;
    const auto blend_whole = [&](const MarkedPixels* except) {
        for (const PixelRect& rect : of.work.rects) {
            for (const ViewDraw& draw : draws)
                blend(geometry, draw.first_triangle, draw.triangle_count, common(rect, of.rect), of.work.canvas,
                      has_movers, except);
        }
    };
    if (std::ranges::all_of(draws, is_soft)) return blend_whole(nullptr);
    BlendedPixels& blended = of.band.blended;
    find_blended(of, draws);
    if (geometry.wide_lanes()) {
        find_covered_wide(of);
    } else {
        find_covered_body<PlainIsa>(of);
    }
    shade_places(geometry, blended.places, has_movers);
    MixedPixels& mixed = of.band.mixed;
    mixed.clear({});
    blend_parts(blended, mixed);
    mixed.mix(blended.places, of.work.canvas);
    blend_whole(&blended.marked);
}

}  // namespace camrig::render::software
