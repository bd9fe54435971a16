#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/world/camera_past.h"
#include "core/world/world.h"

namespace camrig::world {

/// A camera and its world as they will be if nobody says anything: what optical flow leads to. It holds a copy of the
/// world, which moves on when it is asked; the world itself stands where it was.
///
/// Thread: the first that asks. Times in rising order, but for what the world keeps of its past; what is further back
/// is the nearest that is kept.
class CameraFuture {
public:
    /// moves: what events have done to cameras already, for times that are still to come.
    CameraFuture(std::unique_ptr<World> world, std::string name, Camera camera, std::vector<CameraMove> moves)
        : world_(std::move(world)), name_(std::move(name)), camera_(std::move(camera)), moves_(std::move(moves)) {}

    CameraPast::Moment at(TimeNs world_ns);

private:
    void collect();

    std::unique_ptr<World> world_;
    std::string name_;
    Camera camera_;
    std::vector<CameraMove> moves_;  ///< not made yet, in their order
};

/// What an event does to a camera; errors of Camera::changed.
Result<Camera> moved(const Camera& camera, const CameraAction& action, TimeNs begin_ns);

}  // namespace camrig::world
