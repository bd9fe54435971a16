#pragma once

#include <deque>
#include <vector>

#include "core/render/software/divided_pixels.h"
#include "core/render/software/mixed_pixels.h"
#include "core/render/software/pixel_fragments.h"
#include "core/render/software/place_shading.h"
#include "core/render/software/rasterizer.h"

/// What a picture whose pixels show areas works with, beside what all pictures do (view_work.h).
namespace camrig::render::software {

/// The part of a pixel that shows a static surface.
struct StaticFragment {
    SampleMask mask = 0;
    PixelPlane plane;
    glm::vec3 color{0.0f};  ///< linear light
};

/// The marked pixels of static surfaces that show more than one of them. Any other shows one, as its centre does.
struct StaticPixels {
    MarkedPixels marked;
    std::vector<std::uint32_t> first;  ///< into fragments, per marked pixel, and the end
    std::vector<StaticFragment> fragments;
    /// Of a layer on which the shadows of movers fall (shadowed_statics.h), by fragment: its colour without them, and
    /// which of `places` it has, if any. What it has now is in `fragments`, where the picture was drawn.
    std::vector<glm::vec3> lit_colors;
    std::vector<std::uint32_t> place_of_fragment;
    std::vector<ShadedPlace> places;
    std::vector<glm::vec3> positions;  ///< of these, in the optical frame

    void clear(int width, int y0, int y1);
    /// None: the pixel shows what its centre does.
    std::span<const StaticFragment> at(int x, int y) const {
        if (!marked.has(x, y)) return {};
        const std::uint32_t index = marked.index_of(x, y);
        return std::span(fragments).subspan(first[index], first[index + 1] - first[index]);
    }
    std::int64_t bytes() const {
        return marked.bytes() +
               static_cast<std::int64_t>(first.size() * sizeof first[0] + fragments.size() * sizeof fragments[0] +
                                         lit_colors.size() * sizeof lit_colors[0] +
                                         place_of_fragment.size() * sizeof place_of_fragment[0] +
                                         places.size() * sizeof places[0] + positions.size() * sizeof positions[0]);
    }
};

/// What a static layer keeps of them.
struct StaticAreas {
    StaticPixels pixels;
    Plane<std::uint32_t> steps;  ///< of depth in every pixel (packed_steps)
};

/// Pixels of which what is blended covers a part, or lies in front of a part (blended_areas.h).
struct BlendedPixels {
    struct Pixel {
        std::int32_t x = 0, y = 0;
        std::uint32_t first_part = 0;
    };
    struct Part {
        float share = 0.0f;  ///< of the pixel
        glm::vec3 color{0.0f};
    };
    /// What lies before a part, or before some of it, which is another one from there on.
    struct Cover {
        std::uint32_t place = 0, from = 0, to = 0;
    };
    MarkedPixels marked;
    PixelFragments fragments{false};
    std::vector<StaticFragment> of_pixel;  ///< the parts of one pixel
    std::vector<Pixel> pixels;
    std::vector<Part> parts;
    std::vector<Cover> covers;  ///< from far to near
    ShadedPlaces places;

    BlendedPixels() { places.are_blended = true; }
    void clear() {
        pixels.clear();
        parts.clear();
        covers.clear();
        places.clear();
    }
};

/// Of one band.
struct AreaBand {
    StaticPixels statics;
    MarkedPixels crowded;  ///< those of them that no single edge divides: their fragments are looked for
    std::vector<DividedPixel> divided;
    MarkedPixels marked;  ///< where movers are
    PixelFragments fragments;
    ShadedPlaces places;
    std::vector<std::uint32_t> place_of_fragment;
    /// Fragments of what stands still that shadows are looked for on, and their positions; then of `places`.
    std::vector<std::uint32_t> fragment_of_place;
    std::vector<glm::vec3> positions;
    std::vector<std::uint8_t> is_shadowed;
    MixedPixels mixed;
    BlendedPixels blended;
};

/// Of one view.
struct AreaScratch {
    MarkedPixels outlines;
    OutlineEdges edges;  ///< of what stands still
    std::deque<AreaBand> bands;
    int band_count = 0;
    /// Of a view without a layer: what stands still where something moves, and which of that shows beside it.
    TriangleNumbers statics_behind, shown_behind;
    Plane<float> depth_behind;

    void begin(ImageSize size, int count);
    /// The bands of a picture as one.
    void gather(StaticPixels& to) const;
};

}  // namespace camrig::render::software
