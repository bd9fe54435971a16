#pragma once

#include "core/render/software/view_work.h"

/// The pixels of a view that is ready to be drawn (SoftwareDrawer::begin_view).
namespace camrig::render::software {

/// The rows that are drawn, in full width: all or, of a moment, those where its rectangles lie.
PixelRect drawn_rows(const ViewWork& work);
/// One of so many bands of rows that cover them, each of which has about as much work.
PixelRect band_of(const ViewWork& work, int band, int bands);

/// A view is drawn in so many passes; each begins when the one before is through with all bands.
inline constexpr int area_passes = 5;
int passes_of(const ViewWork& work);
/// Draws a band, and what of it a layer keeps. Different bands from different threads.
void draw_rows(ViewWork& work, ViewScratch& scratch, int pass, int band, int bands);

/// The runs of the rows of a rectangle.
std::span<const scene::LensView::BlindRun> blind_runs(const scene::LensView& lens, const PixelRect& rect);

/// What sees nothing is black whatever the background, and nothing comes before it. Of the rows of a rectangle; the
/// canvas may be without colour.
void cover_blind(const scene::SceneView& view, const Canvas& canvas, const PixelRect& rect);

/// Steps of draw_rows, each of a band: what is there before anything is drawn, of a picture in parts or in full.
void put_back(ViewWork& work, const PixelRect& band);
void draw_background(ViewWork& work, const PixelRect& band);
/// The opaque statics are drawn: keeps them, and what is blended over them.
void keep_layer(ViewWork& work, ViewScratch& scratch, const PixelRect& band, AreaBand* areas = nullptr);
/// All that is opaque is drawn: the rest. areas, here and above: of the band, where pixels show areas.
void finish_rows(ViewWork& work, ViewScratch& scratch, const PixelRect& band, AreaBand* areas = nullptr);

}  // namespace camrig::render::software
