#pragma once

#include "core/render/software/view_work.h"

namespace camrig::render::software {

/// Writes what the view sees of the panorama of its backdrop, which is infinitely far away, into the rectangle: in each
/// pixel the panorama at the pixel's direction, in linear light (sampled, panorama_sampling.h).
void draw_panorama(const ViewWork& work, const PixelRect& rect);

}  // namespace camrig::render::software
