#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/frame/frame.h"
#include "core/frame/silhouette.h"
#include "core/truth/truth.h"

/// What each object would show if nothing stood before it.
namespace camrig::truth {

/// Tells for each of these objects which pixels it would show if nothing else were in the world: the same camera, the
/// same instant. `reaches`: none of them shows beyond its box.
using FindSilhouettes = std::function<Result<std::vector<frame::Silhouette>>(std::span<const ObjectId> objects,
                                                                             std::span<const PixelBox> reaches)>;

/// Draws the instance picture of these objects alone: the same camera, the same instant, nothing else in the world.
using DrawAlone = std::function<Result<frame::FrameRef>(std::span<const ObjectId>)>;

/// From pictures: one for each group of objects whose boxes are apart from each other.
FindSilhouettes silhouettes_from(DrawAlone draw_alone);

/// Puts boxes into groups so that those of one group do not touch; each is given as [left, right) x [top, bottom).
/// Returns the group of each box. Large boxes come first into a group, so that the groups are few.
std::vector<std::size_t> group_apart(std::span<const PixelBox> boxes);

}  // namespace camrig::truth
