#pragma once

#include <span>

#include "core/render/software/area_passes.h"

namespace camrig::render::software {

/// Blends draws, from far to near, over what is opaque in the rectangles of a band, which is shaded and, where several
/// surfaces have parts of a pixel, in its `mixed` or in what stands still. In such pixels, and at the outlines of what
/// is blended, a surface is blended over those parts alone that it covers and lies in front of; everywhere else over
/// the whole pixel. has_movers: as of shade().
void blend_areas(const RowsOfView& of, std::span<const ViewDraw> draws, bool has_movers);

}  // namespace camrig::render::software
