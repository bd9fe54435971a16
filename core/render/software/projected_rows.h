#pragma once

#include "core/render/software/view_work.h"

namespace camrig::render::software {

/// Writes the projected picture of the view's backdrop into the rectangle, once the surfaces that show are known: where
/// the pixel's ray meets one of the first `proxies` triangles, what the picture shows of that point; where it meets
/// nothing, what it shows in that direction, infinitely far away. In linear light, as large as the pixel is on the
/// proxy's plane (sampled, pyramid_sampling.h). Beyond its edges the picture goes on as at the edge; black is what its
/// camera could not see at all. What hid the point from that camera is not asked: it shows there, too.
void draw_projected(const ViewWork& work, const ViewGeometry& geometry, std::uint32_t proxies, const PixelRect& rect,
                    Rows<std::uint32_t> numbers);

}  // namespace camrig::render::software
