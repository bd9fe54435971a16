#pragma once

#include "core/render/software/rasterizer.h"

/// Proxies of a backdrop: what its picture shows is not drawn, but movers keep light from it.
namespace camrig::render::software {

/// Of the pixels of the rectangle that show one of the first `proxies` triangles, sets the numbers to 0: the canvas has
/// the picture there. If has_shadows, and where movers are in the way of light, each channel of the canvas is
/// multiplied by its share of light that is left: shaded with them over shaded without them, in linear light. Both
/// have the shadows of what stands still, so nothing is darkened twice, and the colour of the proxy cancels. Nowhere
/// else does a byte change.
void catch_shadows(const ViewGeometry& geometry, std::uint32_t proxies, bool has_shadows, const PixelRect& rect,
                   const Canvas& canvas, Rows<std::uint32_t> numbers);

/// As catch_shadows, and the numbers stay.
void darken_proxies(const ViewGeometry& geometry, std::uint32_t proxies, const PixelRect& rect, const Canvas& canvas,
                    Rows<std::uint32_t> numbers);

}  // namespace camrig::render::software
