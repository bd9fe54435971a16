#pragma once

#include "core/render/software/geometry.h"

namespace camrig::render::software {

/// Depth of the triangles of ViewGeometry alone, in pixels where they are in front of what is there. rect: of whole
/// groups of lanes; rows are aligned to them.
void draw_depth(const ViewGeometry& geometry, const PixelRect& rect, Rows<float> depth);

}  // namespace camrig::render::software
