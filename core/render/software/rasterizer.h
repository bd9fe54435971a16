#pragma once

#include <array>

#include "core/render/software/canvas.h"
#include "core/render/software/geometry.h"

/// From triangles to pixels. A pixel belongs to a triangle if its centre lies inside, or on a top or left edge: what
/// shares an edge leaves no gap and draws no pixel twice. Everything about a pixel follows from the triangle and the
/// pixel alone, so a part of a picture has the same bytes as the whole.
namespace camrig::render::software {

class MarkedPixels;

/// Which triangle of ViewGeometry shows in each pixel, from 1; 0: none of this view. All 0 between views.
using TriangleNumbers = Plane<std::uint32_t>;

/// Writes depth and triangle number where a triangle is in front of what is there. First step of what is opaque: each
/// pixel is shaded once only, by shade_visible, however many surfaces lie behind each other.
void find_visible(const ViewGeometry& geometry, std::uint32_t first_triangle, std::uint32_t count,
                  const PixelRect& rect, const Canvas& canvas, const TriangleNumbers& numbers);

/// Shades the pixels of the rectangle that have a triangle, and sets their numbers back to 0. has_movers, here and
/// below: in the shadows of what moves, too; else as if it were not there.
void shade_visible(const ViewGeometry& geometry, const PixelRect& rect, const Canvas& canvas,
                   const TriangleNumbers& numbers, bool has_movers = true);

/// Blends the triangles of a draw over what is there, in linear light, where nothing is in front of them. except: null,
/// or the pixels that are left as they are.
void blend(const ViewGeometry& geometry, std::uint32_t first_triangle, std::uint32_t count, const PixelRect& rect,
           const Canvas& canvas, bool has_movers = true, const MarkedPixels* except = nullptr);

/// Whether this CPU has instructions for all lanes at once; without them the same bytes take longer.
bool has_wide_lanes();

/// Linear light of the 256 codes.
const std::array<float, 256>& linear_of_code();

/// The sRGB code of a linear value, as shading writes it.
std::uint8_t srgb_code(float linear);

}  // namespace camrig::render::software
