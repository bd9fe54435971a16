#pragma once

#include <memory>
#include <span>

#include "core/base/result.h"
#include "core/frame/frame.h"
#include "core/truth/rolling_eye.h"
#include "core/truth/silhouettes.h"
#include "core/truth/truth.h"
#include "core/world/backdrop/film_player.h"
#include "core/world/snapshot.h"

namespace camrig::truth {

/// The camera and the frame whose truth is asked for.
struct TruthView {
    std::shared_ptr<const std::string> name;
    std::shared_ptr<const world::CameraSpec> spec;
    camera::Pose pose;                    ///< world_from_link at the snapshot's instant
    std::optional<RowsInTime> rows = {};  ///< nullopt: all rows show that instant
    std::optional<camera::Pose> believed_pose = {};
    std::optional<camera::PtzStatus> head = {};
    std::optional<ClockReading> clock = {};
    std::optional<SensorReading> sensor = {};
    fault::FrameFaultsRef faults = {};
    std::optional<world::FilmShot> film = {};
    std::int64_t sequence = 0;
    TimeNs monotonic_ns = 0;
};

/// The frame's pictures, drawn by whoever has a renderer.
struct TruthPictures {
    frame::FrameRef instance;
    frame::FrameRef depth;
};

/// Per-camera cache of the measurements of static objects, which are made anew where the camera's spec or pose, or the
/// static set, is another one.
class StandingObjects {
public:
    StandingObjects();
    ~StandingObjects();

private:
    friend class TruthMaker;
    struct Found;
    std::unique_ptr<Found> found_;
};

/// The truth of one frame. Pixels, visible boxes and occlusion come from the pictures and the silhouettes, which are
/// asked for once; full boxes, 3D boxes and keypoints from the posed surfaces through the camera's exact model. Fails
/// if the silhouettes do, or the camera has no model; resource_exhausted if the halvings of edges are used up
/// (BoxProjector).
Result<TruthOfFrame> make_truth(const TruthView& view, const world::Snapshot& snapshot, const TruthPictures& pictures,
                                const FindSilhouettes& find_silhouettes, StandingObjects* standing = nullptr);

}  // namespace camrig::truth
