#include "tools/view/picture_link.h"

#include <algorithm>
#include <numbers>

#include <camrig/error.h>

namespace camrig::view {
namespace {

using namespace std::chrono_literals;

constexpr int fly_fps = 30;
constexpr auto small_every = 120ms;  ///< for one of all cameras in turn
constexpr auto idle_for = 400ms;
constexpr auto again_after = 500ms;
constexpr int small_width = 240;
constexpr int fly_quality = 88;
constexpr int small_quality = 75;

}  // namespace

PictureLink::PictureLink(client::Rig rig, std::string own_camera, std::function<void()> changed)
    : rig_(std::move(rig)), own_camera_(std::move(own_camera)), changed_(std::move(changed)) {
    world_worker_.emplace([this] { return take_world_picture(); });
    small_worker_.emplace([this] { return take_small_picture(); });
}

PictureLink::~PictureLink() {
    world_worker_.reset();
    small_worker_.reset();
    try {
        leave();
    } catch (const client::Error&) {
        // The rig is gone, and the camera with it; or somebody else has deleted it.
    }
}

void PictureLink::leave() {
    {
        const std::lock_guard lock(making_);
        has_left_ = true;
    }
    rig_.camera(own_camera_).remove();
}

void PictureLink::look(const FlyCamera& from, client::Size size) {
    size = {std::clamp(size.width, 16, 4096), std::clamp(size.height, 16, 4096)};
    {
        const std::lock_guard lock(mutex_);
        if (from == from_ && size == size_) return;
        from_ = from;
        size_ = size;
    }
    world_worker_->wake();
}

void PictureLink::want(std::vector<std::string> cameras) {
    const std::lock_guard lock(mutex_);
    wanted_ = std::move(cameras);
}

std::optional<WorldPicture> PictureLink::take_world() {
    const std::lock_guard lock(mutex_);
    return std::exchange(world_, std::nullopt);
}

std::map<std::string, Picture> PictureLink::take_small() {
    const std::lock_guard lock(mutex_);
    return std::exchange(small_, {});
}

void PictureLink::place(const FlyCamera& from, client::Size size) {
    client::CameraOptions options;
    options.size = size;
    options.vfov_deg = vfov_deg;
    options.position = {from.position.x, from.position.y, from.position.z};
    options.pan_deg = from.pan_rad * 180 / std::numbers::pi;
    options.tilt_deg = from.tilt_rad * 180 / std::numbers::pi;
    options.roll_deg = 0;
    if (!own_) {
        options.fps = fly_fps;
        const std::lock_guard lock(making_);
        if (has_left_) throw client::Error("unavailable", "the window is closing");
        placed_.reset();
        try {
            own_ = rig_.create_camera(own_camera_, options);
            placed_ = {from, size};
        } catch (const client::Error& why) {
            if (why.kind() != "already_exists") throw;
            own_ = rig_.camera(own_camera_);  // made, and the answer was lost
        }
    }
    if (placed_ != std::pair{from, size}) own_->set(options);
    placed_ = {from, size};
}

std::chrono::milliseconds PictureLink::take_world_picture() {
    FlyCamera from;
    client::Size size;
    {
        const std::lock_guard lock(mutex_);
        from = from_;
        size = size_;
    }
    bool is_new = false;
    try {
        is_new = shown_ != std::pair{from, size};
        place(from, size);
        // No min_ns: it waits for what the last command did, and in a world that stands shows it at once.
        const auto frame = own_->frame({.kind = "color", .format = "jpeg", .quality = fly_quality});
        is_new = is_new || frame.sequence != last_sequence_;
        last_sequence_ = frame.sequence;
        if (is_new) {
            auto picture = decode_jpeg(frame.data);
            if (!picture) return again_after;
            shown_ = {from, size};
            const std::lock_guard lock(mutex_);
            world_ = WorldPicture{std::move(*picture), from.pose(), vfov_deg * std::numbers::pi / 180};
        }
    } catch (const client::Error& why) {
        // RigLink says what is wrong. Who has deleted our camera gets it back.
        if (why.kind() == "not_found") {
            own_.reset();
            shown_.reset();
        }
        return again_after;
    }
    if (!is_new) return idle_for;
    changed_();
    return 1000ms / fly_fps;
}

std::chrono::milliseconds PictureLink::take_small_picture() {
    std::string name;
    {
        const std::lock_guard lock(mutex_);
        if (wanted_.empty()) return idle_for;
        name = wanted_[next_small_++ % wanted_.size()];
    }
    try {
        const client::Camera camera = rig_.camera(name);
        const auto frame = camera.frame({.kind = "color", .min_ns = 0, .format = "jpeg", .quality = small_quality});
        if (auto picture = decode_jpeg(frame.data, small_width)) {
            const std::lock_guard lock(mutex_);
            small_[name] = std::move(*picture);
        }
    } catch (const client::Error&) {
        return small_every;  // deleted meanwhile, or the rig is gone, which RigLink says
    }
    changed_();
    return small_every;
}

}  // namespace camrig::view
