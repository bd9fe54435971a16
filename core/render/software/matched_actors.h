#pragma once

#include "core/render/software/view_work.h"

/// What moves before a photo, made as soft and as noisy as it (edge_px and noise of a backdrop).
namespace camrig::render::software {

/// Whether the view's backdrop asks for it; then the picture takes a pass more, because softness reads other bands.
bool is_matched(const ViewWork& work);
/// How far what is soft reaches beyond where it is drawn, in pixels.
int match_reach(const ViewWork& work);

/// Before what moves is drawn in the band: keeps what lies below, and that nothing moves yet.
void keep_below(const ViewWork& work, ViewScratch& scratch, const PixelRect& band);
/// While the numbers of what moves are known: keeps where it shows in the rectangle.
void keep_where_shown(ViewScratch& scratch, const PixelRect& rect);
/// When they are drawn.
void keep_colors(const ViewWork& work, ViewScratch& scratch, const PixelRect& band);
/// When all bands are drawn: the colour and coverage of what moves spread by a Gaussian, over what lies below it, in
/// linear light; then noise by that coverage, which follows from camera, instant and pixel alone.
void match_actors(const ViewWork& work, const ViewScratch& scratch, const PixelRect& band);

}  // namespace camrig::render::software
