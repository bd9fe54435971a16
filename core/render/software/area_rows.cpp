#include "core/render/software/area_rows.h"

#include <algorithm>

#include "core/render/software/channels.h"
#include "core/render/software/coverage.h"
#include "core/render/software/rows.h"
#include "core/render/software/sample_places.h"
#include "core/render/software/shading.h"
#include "core/render/software/shown_parts.h"
#include "core/render/software/view_rows.h"

namespace camrig {
namespace {

constexpr auto share_of_sample = 1.0f / sample_count;

glm::vec3 linear_of(std::uint32_t pixel) {
    const std::array<float, 256>& linear = linear_of_code();
    return {linear[pixel & 0xFF], linear[pixel >> 8 & 0xFF], linear[pixel >> 16 & 0xFF]};
}

glm::vec3 background_of(const ViewWork& work) {
    const Environment& environment = work.scene.scene->environment();
    return glm::clamp(environment.background * environment.exposure, 0.0f, 1.0f);
}

/// The steps of a PixelPlane of a triangle, 16 bits each: as floats without their lower half.
std::uint32_t packed_steps(const ViewGeometry& geometry, std::uint32_t triangle) {
    const Setup s = set_up(geometry.vertices().data(), geometry.triangles()[triangle]);
    const PixelPlane steps = depth_steps(s, depth_plane(s));
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
    return to.add(
        {triangle, static_cast<float>(samples) * share_of_sample, x * subpixels + mean.x, y * subpixels + mean.y});
}

/// A surface is shaded at the mean of the places of the largest of its triangles.
CAMRIG_LANES std::uint32_t add_surface(std::span<const Shown> shown, int surface, int x, int y, ShadedPlaces& to) {
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
    return add_place(largest->triangle, largest->mask, samples, x, y, to);
}

struct RowsOfView {
    ViewWork& work;
    ViewScratch& scratch;
    AreaBand& band;
    const PixelRect& rect;
};

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
    if (shown.empty()) add_static(band, 0, {}, no_triangle);
    const auto first = band.place_of_fragment.size();
    for (std::size_t i = 0; i < shown.size(); ++i) {
        const auto surface = static_cast<std::size_t>(shown[i].surface);
        add_static(band, shown[i].mask, shown[i].plane,
                   surface != i ? band.place_of_fragment[first + surface]
                                : add_surface(shown, shown[i].surface, x, y, band.places));
    }
}

CAMRIG_LANES void add_divided(const RowsOfView& of, int x, int y, const DividedPixel& pixel) {
    if (pixel.mask == all_samples) return;
    const ViewGeometry& geometry = of.scratch.geometry;
    const auto add = [&](std::uint32_t number, SampleMask mask) {
        if (number == 0) return;
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
    shade_places(of.scratch.geometry, of.band.places);
    for (std::size_t i = 0; i < of.band.place_of_fragment.size(); ++i) {
        const std::uint32_t place = of.band.place_of_fragment[i];
        if (place != no_triangle) of.band.statics.fragments[i].color = of.band.places.colors[place];
    }
}

/// Pixels to mix, of one band.
class Mixer {
public:
    Mixer(const RowsOfView& of) : of_(of), background_(background_of(of.work)) {
        of.band.pixels.clear();
        of.band.parts.clear();
    }

    void begin(int x, int y) {
        of_.band.pixels.push_back({x, y, static_cast<std::uint32_t>(of_.band.parts.size())});
        left_ = sample_count;
    }
    void add(int samples, const glm::vec3& color) { add(samples, PixelPart::is_known, color); }
    /// A place, or PixelPart::is_behind.
    void add_place(int samples, std::int32_t place) { add(samples, place, {}); }
    /// Nothing covers the rest.
    void end() {
        if (left_ > 0) add(left_, background_);
    }
    const glm::vec3& background() const { return background_; }

    /// Nothing else is to be shaded there.
    void leave_out(Rows<std::uint32_t> numbers) const {
        for (const MixedPixel& pixel : of_.band.pixels) numbers(pixel.y)[pixel.x] = 0;
    }

    /// What lies behind has the colour that the picture has now.
    void take_behind() {
        for (std::size_t i = 0; i < of_.band.pixels.size(); ++i) {
            const MixedPixel& pixel = of_.band.pixels[i];
            for (PixelPart& part : parts_of(i)) {
                if (part.place != PixelPart::is_behind) continue;
                part.place = PixelPart::is_known;
                part.color = linear_of(of_.work.canvas.color(pixel.y)[pixel.x]);
            }
        }
    }

    void mix() {
        const std::vector<MixedPixel>& pixels = of_.band.pixels;
        for (std::size_t first = 0; first < pixels.size(); first += lane_count) {
            const std::size_t end = std::min(first + lane_count, pixels.size());
            Lanes3 light{};
            for (std::size_t i = first; i < end; ++i) {
                glm::vec3 sum(0.0f);
                for (const PixelPart& part : parts_of(i))
                    sum += part.share *
                           (part.place < 0 ? part.color : of_.band.places.colors[static_cast<std::size_t>(part.place)]);
                const auto lane = static_cast<int>(i - first);
                light.x[lane] = sum.x;
                light.y[lane] = sum.y;
                light.z[lane] = sum.z;
            }
            const IntLanes codes = pixels_of({srgb(light.x), srgb(light.y), srgb(light.z)});
            for (std::size_t i = first; i < end; ++i)
                of_.work.canvas.color(pixels[i].y)[pixels[i].x] =
                    static_cast<std::uint32_t>(codes[static_cast<int>(i - first)]);
        }
    }

private:
    std::span<PixelPart> parts_of(std::size_t pixel) {
        const std::vector<MixedPixel>& pixels = of_.band.pixels;
        const std::size_t first = pixels[pixel].first;
        const std::size_t end = pixel + 1 < pixels.size() ? pixels[pixel + 1].first : of_.band.parts.size();
        return std::span(of_.band.parts).subspan(first, end - first);
    }
    void add(int samples, std::int32_t place, const glm::vec3& color) {
        of_.band.parts.push_back({static_cast<float>(samples) * share_of_sample, place, color});
        left_ -= samples;
    }

    const RowsOfView& of_;
    glm::vec3 background_;
    int left_ = 0;
};

/// Statics that nothing hides.
void add_statics(std::span<const StaticFragment> fragments, Mixer& mixer) {
    for (const StaticFragment& fragment : fragments) {
        const int samples = count_of(fragment.mask);
        if (samples > 0) mixer.add(samples, fragment.color);
    }
    mixer.end();
}

/// The statics of a picture whose layer is kept.
void draw_static_pixels(const RowsOfView& of) {
    const StaticPixels& statics = of.band.statics;
    const Rows<std::uint32_t> numbers = of.scratch.numbers.rows(), steps = of.work.layer->areas.steps.rows();
    for (int y = of.rect.y0; y < of.rect.y1; ++y) {
        std::uint32_t last = 0, made = 0;
        for (int x = of.rect.x0; x < of.rect.x1; ++x) {
            const std::uint32_t number = numbers(y)[x];
            if (number != last) made = number == 0 ? 0 : packed_steps(of.scratch.geometry, number - 1);
            last = number;
            steps(y)[x] = made;
        }
    }
    Mixer mixer(of);
    for (int y = of.rect.y0; y < of.rect.y1; ++y) {
        statics.marked.each_of_row(y, [&](int x, int, std::uint32_t) {
            const auto fragments = statics.at(x, y);
            if (fragments.empty()) return;
            mixer.begin(x, y);
            add_statics(fragments, mixer);
        });
    }
    describe_visible(of.scratch, of.rect, of.work);
    mixer.leave_out(numbers);
    shade_visible(of.scratch.geometry, of.rect, of.work.canvas, of.scratch.numbers);
    mixer.mix();
}

/// Remembers what stands still where movers will be drawn over it.
void keep_behind(const RowsOfView& of) {
    for (const PixelRect& rect : of.work.movers.rects) {
        const PixelRect part = common(rect, of.rect);
        copy(of.scratch.numbers.rows(), of.scratch.areas.statics_behind.rows(), part);
        copy(of.work.canvas.depth, of.scratch.areas.depth_behind.rows(), part);
    }
}

void mark_statics(const RowsOfView& of) {
    AreaBand& band = of.band;
    band.statics.clear(of.work.whole.width(), of.rect.y0, of.rect.y1);
    mark_crossings(of.scratch.geometry, of.rect, of.scratch.areas.outlines, of.scratch.numbers, 0, band.statics.marked);
    band.statics.marked.number();
    band.crowded.clear(of.work.whole.width(), of.rect.y0, of.rect.y1);
    band.divided.clear();
    find_divided(of.scratch.geometry, of.rect, band.statics.marked, of.scratch.areas.edges, of.scratch.numbers.rows(),
                 of.work.canvas.depth, band.crowded, band.divided);
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
    mark_outlines(of.scratch.geometry, range.first, range.count, hull, of.work.canvas.depth, outlines);
}

/// What stands still in a marked pixel, as one or more parts.
void show_statics(const RowsOfView& of, std::span<const StaticFragment> fragments, int x, int y, ShownParts& to) {
    for (const StaticFragment& fragment : fragments) {
        if (fragment.mask != 0) {
            Shown& part = to.append(fragment.mask, fragment.plane);
            part.color = fragment.color;
        }
    }
    if (!fragments.empty()) return;
    Shown& whole = to.append(all_samples, {});
    if (const StaticLayer* const layer = of.work.layer; layer != nullptr) {
        whole.plane = plane_of(layer->depth.rows()(y)[x], layer->areas.steps.rows()(y)[x]);
        whole.color = linear_of(layer->color.rows()(y)[x]);
    } else {
        const std::uint32_t number = of.scratch.areas.statics_behind.rows()(y)[x];
        whole.plane = plane_of(of.scratch.areas.depth_behind.rows()(y)[x],
                               number == 0 ? 0 : packed_steps(of.scratch.geometry, number - 1));
        whole.is_behind = true;
    }
}

template <typename Isa>
CAMRIG_LANES void resolve_movers_body(const RowsOfView& of, Mixer& mixer) {
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
                mixer.begin(x, y);
                add_statics(fragments, mixer);
                return;
            }
            parts.clear();
            show_statics(of, fragments, x, y, parts);
            of.band.fragments.each_of(
                pixel, [&](const Fragment& fragment) __attribute__((always_inline)) { parts.add<Isa>(fragment); });
            const std::span<Shown> shown = parts.all();
            find_surfaces(geometry, shown);
            if (is_mover && is_as_its_middle(shown, number)) return;
            mixer.begin(x, y);
            std::array<int, sample_count + 2> samples{};
            for (const Shown& part : shown) samples[static_cast<std::size_t>(part.surface)] += count_of(part.mask);
            for (std::size_t i = 0; i < shown.size(); ++i) {
                const Shown& part = shown[i];
                if (part.surface != static_cast<int>(i)) continue;
                if (part.triangle != no_triangle) {
                    mixer.add_place(samples[i],
                                    static_cast<std::int32_t>(add_surface(shown, part.surface, x, y, of.band.places)));
                } else if (part.is_behind) {
                    of.scratch.areas.shown_behind.rows()(y)[x] = of.scratch.areas.statics_behind.rows()(y)[x];
                    mixer.add_place(samples[i], PixelPart::is_behind);
                } else {
                    mixer.add(samples[i], part.color);
                }
            }
            mixer.end();
        });
    }
}
CAMRIG_WIDE void resolve_movers_wide(const RowsOfView& of, Mixer& mixer) {
    resolve_movers_body<Avx2Isa>(of, mixer);
}

void mark_movers(const RowsOfView& of) {
    AreaBand& band = of.band;
    band.marked.clear(of.work.whole.width(), of.rect.y0, of.rect.y1);
    for (const PixelRect& rect : of.work.rects)
        mark_crossings(of.scratch.geometry, common(rect, of.rect), of.scratch.areas.outlines, of.scratch.numbers,
                       of.scratch.statics.count, band.marked);
    band.marked.number();
}

void draw_movers(const RowsOfView& of) {
    AreaBand& band = of.band;
    const ViewGeometry& geometry = of.scratch.geometry;
    const TriangleRange& range = of.scratch.movers;
    band.fragments.clear(band.marked.count());
    band.places.clear();
    find_fragments(geometry, range.first, range.count, of.rect, band.marked, band.fragments);
    Mixer mixer(of);
    if (geometry.wide_lanes()) {
        resolve_movers_wide(of, mixer);
    } else {
        resolve_movers_body<PlainIsa>(of, mixer);
    }
    shade_places(geometry, band.places);
    if (of.work.layer == nullptr) {
        // A background behind a mover is in the picture already: nothing is shaded over it yet.
        for (const PixelRect& rect : of.work.movers.rects)
            shade_visible(geometry, common(rect, of.rect), of.work.canvas, of.scratch.areas.shown_behind);
        mixer.take_behind();
    }
    for (const PixelRect& rect : of.work.rects) describe_visible(of.scratch, common(rect, of.rect), of.work);
    mixer.leave_out(of.scratch.numbers.rows());
    for (const PixelRect& rect : of.work.rects)
        shade_visible(geometry, common(rect, of.rect), of.work.canvas, of.scratch.numbers);
    mixer.mix();
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
            scratch.areas.edges.clear(rect);
            return mark_outlines(scratch.geometry, range.first, range.count, rect, work.canvas.depth,
                                 scratch.areas.outlines, &scratch.areas.edges);
        }
        case 1:
            return mark_statics(of);
        case 2:
            if (!work.is_in_parts) draw_statics(of);
            return find_movers(of);
        case 3:
            return mark_movers(of);
        default:
            return draw_movers(of);
    }
}

void StaticPixels::clear(int width, int y0, int y1) {
    marked.clear(width, y0, y1);
    fragments.clear();
    first.assign(1, 0);
}

void AreaScratch::begin(ImageSize size, int count) {
    outlines.clear(size.width, 0, size.height);
    edges.fit(size);
    while (bands.size() < static_cast<std::size_t>(count)) bands.emplace_back();
    band_count = count;
    statics_behind.fit(size);
    shown_behind.fit(size);
    depth_behind.fit(size);
}

void AreaScratch::gather(StaticPixels& to) const {
    const MarkedPixels& last = bands[static_cast<std::size_t>(band_count) - 1].statics.marked;
    to.clear(last.words() * MarkedPixels::word_bits, 0, last.y1());
    to.first.clear();
    for (int i = 0; i < band_count; ++i) {
        const StaticPixels& from = bands[static_cast<std::size_t>(i)].statics;
        const auto offset = static_cast<std::uint32_t>(to.fragments.size());
        to.marked.take(from.marked);
        to.fragments.insert(to.fragments.end(), from.fragments.begin(), from.fragments.end());
        for (std::size_t k = 0; k + 1 < from.first.size(); ++k) to.first.push_back(from.first[k] + offset);
    }
    to.marked.number();
    to.first.push_back(static_cast<std::uint32_t>(to.fragments.size()));
    to.fragments.shrink_to_fit();
    to.first.shrink_to_fit();
}

}  // namespace camrig
