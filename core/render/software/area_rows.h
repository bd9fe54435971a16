#pragma once

#include "core/render/software/view_work.h"

namespace camrig::render::software {

/// draw_rows for pictures whose pixels show the areas of surfaces (Antialias::coverage).
///
/// Numbers and depth at pixel centres are found as always, and other kinds than colour (channels.h) come of
/// them. Pixels that show one surface are shaded as always. Those that an outline touches, or at which surfaces cross,
/// are marked. There each triangle covers some of 64 coverage samples, the nearest one has a sample, and each surface
/// is shaded once, at the mean of the samples that it has.
///
/// Statics are resolved among themselves first, then what moves over them: a static layer keeps the first half.
///   pass 0  statics at the centres; their outlines
///   pass 1  where statics cross: looks at the rows beside the band
///   pass 2  statics resolved and shaded in marked pixels, a layer is kept; movers at the centres, their outlines
///   pass 3  where movers cross anything, as pass 1
///   pass 4  movers over statics in the marked pixels of both; all shaded and blended
void draw_area_rows(ViewWork& work, ViewScratch& scratch, int pass, int number, const PixelRect& band);

}  // namespace camrig::render::software
