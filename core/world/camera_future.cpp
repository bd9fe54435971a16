#include "core/world/camera_future.h"

#include <algorithm>
#include <iterator>

namespace camrig::world {

Result<Camera> moved(const Camera& camera, const CameraAction& action, TimeNs begin_ns) {
    CameraPatch patch;
    patch.pose = action.pose;
    if (action.vfov_rad) patch.optics = VerticalFov{*action.vfov_rad};
    if (action.clock) patch.change([clock = action.clock](CameraSpec& spec) { spec.clock = clock; });
    return camera.changed(patch, begin_ns, action.duration_ns);
}

void CameraFuture::collect() {
    std::ranges::move(world_->take_camera_moves(), std::back_inserter(moves_));
    const std::optional<Mount>& mount = camera_.spec()->mount;
    for (const Departure& departure : world_->take_departures())
        if (mount && mount->actor == departure.instance.info->name)
            camera_.leave(departure.instance, departure.world_ns);
}

CameraPast::Moment CameraFuture::at(TimeNs world_ns) {
    world_->advance_to(world_ns);
    world_ns = std::max({world_ns, TimeNs{0}, world_->last_step_ns() - StepHistory::span_ns});
    collect();
    std::erase_if(moves_, [&](const CameraMove& move) {
        if (move.world_ns > world_ns) return false;
        const auto* const action = std::get_if<CameraAction>(&move.action);
        if (action == nullptr || action->camera != name_) return true;
        // What the rig would log and leave is left here.
        if (auto there = moved(camera_, *action, move.world_ns)) camera_ = std::move(*there);
        return true;
    });
    SnapshotRef snapshot = world_->snapshot(world_ns);
    camera::CameraState state = camera_.at(*snapshot);
    return {std::move(snapshot), std::move(state)};
}

}  // namespace camrig::world
