#pragma once

#include "core/render/software/view_work.h"

/// What a camera with a sensor makes of the light: two passes over bands of rows, then the statistics. The first is
/// through with all bands before the second begins.
namespace camrig::render::software {

/// Where the light is gathered and the numbers go; both frames are there if they are wanted.
void begin_taking(ViewWork& work, std::array<Plane<float>, 3>& light, std::vector<std::uint16_t>& numbers);
/// If the layer's light is gathered for the sensor: that of the canvas counts where it is drawn from now on, in the
/// rectangles to begin with.
void look_at_light(ViewWork& work, const StaticLayer& layer, std::span<const PixelRect> rects);
/// More of them: ViewWork::new_tiles are to be filled with the layer.
void mark_drawn(ViewWork& work, std::span<const PixelRect> rects);
/// Light to numbers.
void expose_rows(const ViewWork& work, const PixelRect& band);
/// Numbers to the picture.
void develop_rows(const ViewWork& work, const PixelRect& band);
/// The picture is whole: tells the camera's control loops.
void end_taking(const ViewWork& work);

}  // namespace camrig::render::software
