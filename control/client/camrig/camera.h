#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include <camrig/frame.h>
#include <camrig/parameters.h>
#include <nlohmann/json.hpp>

namespace camrig::client {

class Connections;

/// The pan/tilt/zoom head of a camera (docs/ptz.md). Every call answers at once with where the head is:
/// docs/control-protocol.md, ptz.status. Thread: any.
class PtzHead {
public:
    nlohmann::json status() const;
    /// {"pan_deg": 30, "tilt_deg": -10, "zoom": 2, "mode": "relative", ...}, or {"mode": "fov", "x": 0.5, "y": 0.2}
    nlohmann::json move(nlohmann::json params) const;
    nlohmann::json stop(bool pan_tilt = true, bool zoom = true) const;
    nlohmann::json preset_set(const std::string& preset) const;
    nlohmann::json preset_goto(const std::string& preset) const;
    nlohmann::json preset_remove(const std::string& preset) const;
    /// Stops: [{"preset": "door", "dwell_s": 5, "speed": 1}, ...]
    nlohmann::json tour_set(const std::string& tour, nlohmann::json stops) const;
    nlohmann::json tour_start(const std::string& tour) const;
    nlohmann::json tour_remove(const std::string& tour) const;
    nlohmann::json home_set() const;
    nlohmann::json home_goto() const;

private:
    friend class Camera;
    PtzHead(std::shared_ptr<Connections> connections, std::string camera)
        : connections_(std::move(connections)), camera_(std::move(camera)) {}
    nlohmann::json call(const char* method, nlohmann::json params = nlohmann::json::object()) const;

    std::shared_ptr<Connections> connections_;
    std::string camera_;
};

/// A camera by its name. Holds no state: what it is now, get() asks the rig. Copies are the same camera.
///
/// Thread: any. Every call throws Error; not_found when the camera is gone.
class Camera {
public:
    const std::string& name() const { return name_; }

    CameraState get() const;
    /// Changes what is given; returns all of it, with the world time from which it shows in applied_ns. Pose and field
    /// of view get there over so many seconds of world time, at arrives_ns.
    CameraState set(const CameraOptions& options, double seconds = 0.0) const;
    /// Deletes the camera in the rig; its streams end. Returns the world time from which it is gone.
    std::int64_t remove() const;

    /// The latest due frame, drawn now if nobody was watching.
    Frame frame(const FrameRequest& request = {}) const;
    Frame depth(std::int64_t min_ns = 0) const;
    /// Optical flow, pixels until the camera's next frame (docs/truth.md): flow32f, two floats a pixel.
    Frame flow(std::int64_t min_ns = 0) const;
    /// How much of each pixel's light dirt and covers on the lens take (docs/faults.md): gray8, 255: all.
    Frame soiling(std::int64_t min_ns = 0) const;
    /// Ids of objects, the same in all cameras and in truth().
    Frame instances(std::int64_t min_ns = 0) const;
    /// The truth of the latest due frame, as docs/truth.md explains it: camera, pose and every object in view.
    nlohmann::json truth(std::int64_t min_ns = 0) const;
    /// Its pan/tilt/zoom head; every call throws Error `unsupported` when it has none.
    PtzHead ptz() const { return PtzHead(connections_, name_); }
    /// Writes the latest due frame, as the rig encodes it, to a .jpg, .jpeg or .png file.
    void snapshot(const std::filesystem::path& file) const;
    /// Where a program finds this camera: kind is mjpeg, jpg, png, rtsp (main), rtsp-sub or rtsp-mjpeg.
    std::string url(const std::string& kind = "mjpeg") const;

private:
    friend class Rig;
    Camera(std::shared_ptr<Connections> connections, std::string name)
        : connections_(std::move(connections)), name_(std::move(name)) {}

    std::shared_ptr<Connections> connections_;
    std::string name_;
};

}  // namespace camrig::client
