#pragma once

#include <functional>
#include <span>

#include "core/base/result.h"
#include "core/frame/frame.h"
#include "core/truth/truth.h"
#include "core/world/snapshot.h"

namespace camrig {

/// The camera and the frame whose truth is asked for.
struct TruthView {
    std::shared_ptr<const std::string> name;
    std::shared_ptr<const CameraSpec> spec;
    Pose pose;  ///< world_from_link at the snapshot's instant
    std::int64_t sequence = 0;
    TimeNs monotonic_ns = 0;
};

/// The frame's pictures, drawn by whoever has a renderer.
struct TruthPictures {
    FrameRef instance;
    FrameRef depth;
};

/// Draws the instance picture of these objects alone: the same camera, the same instant, nothing else in the world.
using DrawAlone = std::function<Result<FrameRef>(std::span<const ObjectId>)>;

/// The truth of one frame. Pixels, visible boxes and occlusion come from the pictures; full boxes, 3D boxes and
/// keypoints from the posed surfaces through the camera's exact model. `draw_alone` is called once for each group of
/// objects whose full boxes are apart from each other. Fails only if that does, or the camera has no model.
Result<TruthOfFrame> make_truth(const TruthView& view, const Snapshot& snapshot, const TruthPictures& pictures,
                                const DrawAlone& draw_alone);

/// Puts boxes into groups so that those of one group do not touch; each is given as [left, right) x [top, bottom).
/// Returns the group of each box. Large boxes come first into a group, so that the groups are few.
std::vector<std::size_t> group_apart(std::span<const PixelBox> boxes);

}  // namespace camrig
