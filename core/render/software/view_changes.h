#pragma once

#include "core/render/software/software_shadows.h"
#include "core/render/software/view_work.h"

/// What of a camera's pictures changes from frame to frame, while what stands still is kept (StaticLayer).
namespace camrig::render::software {

/// Where what moves and its shadows are now: the rectangles that are drawn over the view's layer.
void find_changed_rects(ViewWork& work, const SoftwareShadows& shadows);
/// The same, and where the view's pictures differ from the last ones, and from what the frames' memory holds, which may
/// be earlier pictures of the camera.
void find_changes(ViewWork& work, const SoftwareShadows& shadows);
/// Notes what the finished frames show, for those that follow.
void note_shown(ViewWork& work);

}  // namespace camrig::render::software
