#pragma once

#include <memory>
#include <utility>

#include "core/world/camera.h"
#include "core/world/step_history.h"

namespace camrig::world {

/// A camera and its world over the last while, as both were known at one instant: what an exposure looks at.
///
/// A value; any thread.
class CameraPast {
public:
    /// So far back it reaches at most.
    static constexpr TimeNs span_ns = StepHistory::span_ns;

    struct Moment {
        SnapshotRef snapshot;
        camera::CameraState state;
    };

    CameraPast(std::shared_ptr<const WorldPast> world, Camera camera)
        : world_(std::move(world)), camera_(std::move(camera)) {}

    /// At that time, or the nearest that is kept.
    Moment at(TimeNs world_ns) const {
        SnapshotRef snapshot = world_->at(world_ns);
        camera::CameraState state = camera_.at(*snapshot);
        return {std::move(snapshot), std::move(state)};
    }

    /// What the camera's clock says at that time; nullopt: it has none.
    std::optional<ClockReading> clock_at(TimeNs world_ns) const { return camera_.clock_at(world_ns); }

private:
    std::shared_ptr<const WorldPast> world_;
    Camera camera_;
};

}  // namespace camrig::world
