#include "core/world/camera.h"

#include "core/world/mount.h"
#include "core/world/step_history.h"

namespace camrig {

static_assert(Timeline<Pose>::kept_ns >= StepHistory::span_ns);

Camera::Camera(CameraSpec spec)
    : spec_(std::make_shared<const CameraSpec>(std::move(spec))), pose_(spec_->pose), intrinsics_(spec_->intrinsics) {}

Result<Camera> Camera::changed(const CameraPatch& patch, TimeNs begin_ns, TimeNs duration_ns) const {
    const bool turns = patch.pan_rad || patch.tilt_rad;
    CameraSpec base = *spec_;
    if (turns) base.pose = pose_.at(begin_ns);
    auto spec = patch_camera_spec(base, patch);
    if (!spec) return std::unexpected(spec.error());

    Camera next = *this;
    next.spec_ = std::make_shared<const CameraSpec>(std::move(*spec));
    const CameraSpec &before = *spec_, &after = *next.spec_;
    if (after.mount != before.mount) {
        next.pose_ = Timeline(after.pose);
        next.left_ = Timeline(Pose{});
    } else if (patch.pose || turns) {
        next.pose_.go_to(after.pose, begin_ns, duration_ns);
    }
    const Intrinsics &from = before.intrinsics, &to = after.intrinsics;
    if ((patch.optics || patch.zoom) && after.size == before.size)
        next.intrinsics_.go_to(to, begin_ns, from.cx == to.cx && from.cy == to.cy ? duration_ns : 0);
    else if (from != to)
        next.intrinsics_ = Timeline(to);
    return next;
}

Camera Camera::in_another_world(const Snapshot& last) const {
    Camera camera(*spec_);
    if (spec_->mount) camera.left_ = Timeline(frame_in(last));
    return camera;
}

void Camera::leave(const Instance& carrier, TimeNs world_ns) {
    left_.go_to(mount_frame(carrier, spec_->mount->node), world_ns, 0);
}

Pose Camera::frame_in(const Snapshot& world) const {
    const Mount& mount = *spec_->mount;
    const auto carrier =
        std::ranges::find_if(world.movers, [&](const Instance& mover) { return mover.info->name == mount.actor; });
    return carrier == world.movers.end() ? left_.at(world.world_ns) : mount_frame(*carrier, mount.node);
}

CameraState Camera::at(const Snapshot& world) const {
    const Pose pose = pose_.at(world.world_ns);
    return {world.world_ns, spec_->mount ? in_world(frame_in(world), pose) : pose, intrinsics_.at(world.world_ns)};
}

CameraSpec Camera::spec_at(TimeNs world_ns) const {
    CameraSpec spec = *spec_;
    spec.pose = pose_.at(world_ns);
    spec.intrinsics = intrinsics_.at(world_ns);
    return spec;
}

}  // namespace camrig
