#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <camrig/rig.h>

#include "core/camera/pose.h"
#include "tools/view/fly_camera.h"
#include "tools/view/picture.h"
#include "tools/view/worker.h"

namespace camrig::view {

/// The picture of the fly-through camera, and what it was taken with: lines drawn over it use these, not newer ones.
struct WorldPicture {
    Picture picture;
    camera::Pose pose;
    double vfov_rad = 1;
};

/// Pictures for the window: through a camera of its own, which it makes, moves and deletes at its end, and small ones
/// of all others. It takes them when it has shown the one before (frame.get), so it holds nobody up and never steps a
/// world.
///
/// Thread: the window's; the rig is asked on threads of this class.
class PictureLink {
public:
    PictureLink(client::Rig rig, std::string own_camera, std::function<void()> changed);
    /// Deletes the camera; within a second also when the rig does not answer.
    ~PictureLink();
    /// Deletes the camera for good: from then on it is not made again. For an end without a destructor, on any thread.
    /// Throws client::Error where that fails.
    void leave();

    /// From where the world is to be seen, and how large, in pixels.
    void look(const FlyCamera& from, client::Size size);
    /// Whose small pictures are wanted.
    void want(std::vector<std::string> cameras);

    /// The newest picture of the world, once.
    std::optional<WorldPicture> take_world();
    /// Small pictures that are new since the last call, by camera.
    std::map<std::string, Picture> take_small();

    static constexpr double vfov_deg = 60;

private:
    /// Makes our camera or moves it.
    void place(const FlyCamera& from, client::Size size);
    std::chrono::milliseconds take_world_picture();
    std::chrono::milliseconds take_small_picture();

    const client::Rig rig_;
    const std::string own_camera_;
    const std::function<void()> changed_;
    std::mutex making_;      ///< held while our camera is made
    bool has_left_ = false;  ///< guarded by making_
    std::mutex mutex_;
    FlyCamera from_;  ///< guarded by mutex_, as all that follows
    client::Size size_{960, 540};
    std::optional<WorldPicture> world_;
    std::vector<std::string> wanted_;
    std::map<std::string, Picture> small_;
    std::optional<client::Camera> own_;  ///< of the thread that takes world pictures, as the next three
    std::optional<std::pair<FlyCamera, client::Size>> placed_;  ///< where own_ is
    std::optional<std::pair<FlyCamera, client::Size>> shown_;   ///< what the last picture was taken from
    std::int64_t last_sequence_ = -1;
    std::size_t next_small_ = 0;  ///< of the thread that takes small pictures
    std::optional<Worker> world_worker_;
    std::optional<Worker> small_worker_;
};

}  // namespace camrig::view
