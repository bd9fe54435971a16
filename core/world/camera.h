#pragma once

#include <algorithm>
#include <memory>

#include "core/camera/camera_state.h"
#include "core/camera/clock.h"
#include "core/camera/ptz_head.h"
#include "core/camera/timeline.h"
#include "core/fault/fault_plan.h"
#include "core/world/camera_spec.h"
#include "core/world/snapshot.h"

namespace camrig::world {

/// A camera as a function of world time: what commands and events said of it so far, and what follows from that for
/// any time. Nothing is carried on from picture to picture: states may be asked for in any order, and a picture that is
/// not drawn changes nothing.
///
/// A value; any thread. Commands make another one of it.
class Camera {
public:
    /// At rest.
    explicit Camera(CameraSpec spec = {});

    /// Where its last command brings it: pose and intrinsics are those from arrives_ns() on. Never null.
    const std::shared_ptr<const CameraSpec>& spec() const { return spec_; }
    /// World time from which it is where its last command sent it.
    TimeNs arrives_ns() const;

    /// As patch_camera_spec() changes it at begin_ns. Pose and focal length come there over duration_ns, all else
    /// changes at once; so do the pose on another mount, and intrinsics of another size or principal point. A motion of
    /// what the patch does not name goes on.
    Result<Camera> changed(const CameraPatch& patch, TimeNs begin_ns, TimeNs duration_ns) const;
    /// With its head told something. unsupported: it has none.
    Result<Camera> with_head(const std::function<Result<void>(camera::PtzHead&)>& tell) const;
    /// unsupported: it has none.
    Result<const camera::PtzHead*> head() const;
    /// A move of its head as it is meant by who sees the picture of that time, in angles: where the picture is turned
    /// over, relative and continuous tilt is too; a move by fov has the angles of its place. Of that: unsupported: it
    /// has no head; invalid_argument: the lens shows nothing there.
    Result<camera::PtzMove> in_angles(camera::PtzMove move, TimeNs world_ns) const;

    /// How it fails.
    fault::FaultPlan& faults() { return faults_; }
    const fault::FaultPlan& faults() const { return faults_; }

    /// Of another world, whose time begins at 0: it has arrived, nothing of it fails, and what it was mounted on last
    /// stays where it was.
    Camera in_another_world(const Snapshot& last) const;
    /// What it is mounted on has gone from the world, and was this then: the camera stays there.
    void leave(const Instance& carrier, TimeNs world_ns);

    /// As it is at the snapshot's time, anywhere in what the world and Timeline keep of the past.
    camera::CameraState at(const Snapshot& world) const;
    /// Where its commands put it in the world: without what its head turns and faults move.
    camera::Pose base_at(const Snapshot& world) const;
    /// What its clock says at that time, which need not be that of a frame; nullopt: it has none.
    std::optional<ClockReading> clock_at(TimeNs world_ns) const;
    /// The spec with pose (in the frame of its mount) and intrinsics of a time: camera.create makes one that is so.
    CameraSpec spec_at(TimeNs world_ns) const;

private:
    /// On what it is, and where in the frame of that, without its head.
    struct Place {
        std::optional<Mount> mount;
        camera::Pose pose;
    };
    friend Place between(const Place& a, const Place& b, double share);
    /// world_from_mount.
    camera::Pose frame_in(const Snapshot& world, const Mount& mount) const;
    /// Where its head would look at what the picture of that time shows at a place (PtzMove).
    Result<camera::PtzPosition> angles_at(double x, double y, TimeNs world_ns) const;

    std::shared_ptr<const CameraSpec> spec_;
    camera::Timeline<Place> place_;
    camera::Timeline<camera::Intrinsics> intrinsics_;  ///< without its head
    std::optional<camera::PtzHead> head_, head_before_;
    TimeNs head_since_ns_ = 0;  ///< until then head_before_ was there
    camera::Clock clock_;
    fault::FaultPlan faults_;
    camera::Timeline<camera::Pose> left_{
        camera::Pose{}};  ///< world_from_mount while what it is mounted on is not there
};

}  // namespace camrig::world
