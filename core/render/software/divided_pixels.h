#pragma once

#include <cstdint>
#include <vector>

#include "core/render/software/geometry.h"
#include "core/render/software/marked_pixels.h"
#include "core/render/software/pixel_part.h"

/// Pixels that one edge of an outline divides: most of those that are marked. What lies on its two sides shows at the
/// centre of this pixel and at that of the next one beyond the edge; no other triangle needs to be looked at.
namespace camrig::render::software {

struct DividedPixel {
    SampleMask mask = all_samples;  ///< the samples that show what the centre does; all: nothing else is seen
    std::uint32_t other = 0;        ///< the triangle of the other samples, from 1; 0: none
};

/// Adds the marked pixels of the rectangle that one edge divides, from left to right and top to bottom, and marks all
/// others as crowded: more edges go through them or end there, surfaces cross, masks end. numbers, depth: of opaque
/// surfaces at the pixel centres. Reads the rows beside the rectangle too, as far as the picture is drawn.
void find_divided(const ViewGeometry& geometry, const PixelRect& rect, const PixelRect& drawn,
                  const MarkedPixels& marked, const OutlineEdges& edges, Rows<std::uint32_t> numbers, Rows<float> depth,
                  MarkedPixels& crowded, std::vector<DividedPixel>& divided);

}  // namespace camrig::render::software
