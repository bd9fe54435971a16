#pragma once

#include "core/render/software/view_work.h"

/// The pixels of a view that is ready to be drawn (SoftwareDrawer::begin_view).
namespace camrig {

/// One of so many bands of rows that cover the picture, each of which has about as much work.
PixelRect band_of(const ViewWork& work, int band, int bands);

/// Draws a band, and what of it a layer keeps. Different bands from different threads.
void draw_rows(ViewWork& work, ViewScratch& scratch, const PixelRect& band);

}  // namespace camrig
