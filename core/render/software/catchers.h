#pragma once

#include "core/render/software/view_work.h"

/// Proxies of a backdrop: what its picture shows is not drawn, but movers keep light from it.
namespace camrig::render::software {

/// Whose light counts in the pixels of the rectangle, into scratch.receivers, and how near it is, into
/// scratch.receiver_depth: what only catches shadows, where it is before a proxy or before nothing; else what `numbers`
/// and the canvas have. Only where scratch.catchers is not 0.
void find_receivers(ViewScratch& scratch, const PixelRect& rect, const Canvas& canvas, Rows<std::uint32_t> numbers);

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
