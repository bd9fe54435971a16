#pragma once

#include "core/render/software/view_work.h"

namespace camrig::render::software {

/// Writes what the view sees of the panorama of its backdrop, which is infinitely far away, into the rectangle: in each
/// pixel the panorama at the pixel's direction, in linear light. Where a pixel of the view is smaller than one of the
/// panorama, that is bilinear; else the mean over the pixel: of up to 16 samples along the longer side of what it
/// sees, from the two levels whose pixels are nearest to the shorter one (as EXT_texture_filter_anisotropic).
void draw_panorama(const ViewWork& work, const PixelRect& rect);

}  // namespace camrig::render::software
