#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/camera/pose.h"
#include "tools/view/sight.h"

namespace camrig::view {

/// What of a camera is held: the body (moves over the ground at its height), the body to lift it, or the handle (turns
/// it).
enum class Grip { body, lift, handle };

/// A place on the screen where a camera can be taken hold of.
struct GripPoint {
    std::string camera;
    Grip grip = Grip::body;
    glm::dvec2 screen{0.0};
};

/// The grip nearest to the mouse, within reach_px or so; of a body and a handle that are about as near, the body.
const GripPoint* nearest_grip(std::span<const GripPoint> grips, glm::dvec2 mouse, double reach_px = 12);

/// A camera that is being dragged from `start`.
class CameraDrag {
public:
    /// `ray`: under the mouse as it takes hold. `handle_m`: how far from the camera its handle is.
    CameraDrag(std::string camera, Grip grip, const camera::Pose& start, const Ray& ray, double handle_m);

    const std::string& camera() const { return camera_; }
    Grip grip() const { return grip_; }
    /// Whether the camera was moved in this drag.
    bool has_moved() const { return has_moved_; }
    void set_moved() { has_moved_ = true; }
    /// The pose when the mouse is on `ray`: what was taken hold of stays under it. The last sound one where that cannot
    /// be, as with the mouse above the horizon.
    const camera::Pose& to(const Ray& ray);

    /// Farther from the eye than this a pixel is metres, so nothing is dragged there.
    static constexpr double max_distance_m = 300;

private:
    std::optional<glm::dvec3> on_plane(const Ray& ray) const;

    std::string camera_;
    Grip grip_;
    camera::Pose start_;
    camera::Pose present_;
    double handle_m_;
    double roll_rad_;
    bool has_moved_ = false;
    glm::dvec3 offset_{0.0};  ///< from the point under the mouse to what is moved
};

}  // namespace camrig::view
