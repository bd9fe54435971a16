#pragma once

#include <optional>
#include <utility>

#include <glm/glm.hpp>

#include "core/base/image_size.h"
#include "core/camera/pose.h"

namespace camrig::view {

/// A half line in the world; the direction has length 1.
struct Ray {
    glm::dvec3 origin;
    glm::dvec3 direction;
};

/// How the fly-through picture on the screen shows the world: a pinhole camera whose picture fills a rectangle of the
/// window. Screen coordinates are pixels from the window's top left; the middle of a picture of WxH pixels is its
/// middle, W/2, H/2.
class Sight {
public:
    Sight() = default;
    /// `origin` and `extent`: the rectangle on the screen. `vfov_rad` is edge to edge of it.
    Sight(const camera::Pose& pose, double vfov_rad, glm::dvec2 origin, glm::dvec2 extent);

    double focal_px() const { return focal_px_; }
    glm::dvec3 position() const { return position_; }
    /// Where a point is seen, also outside of the rectangle; none nearer than near_m before the camera.
    std::optional<glm::dvec2> project(const glm::dvec3& point) const;
    /// The part of a line that is before the camera.
    std::optional<std::pair<glm::dvec2, glm::dvec2>> project(const glm::dvec3& a, const glm::dvec3& b) const;
    /// What is under a place on the screen.
    Ray ray(glm::dvec2 screen) const;

    static constexpr double near_m = 0.05;

private:
    glm::dvec2 screen_of(const glm::dvec3& in_optical) const;

    glm::dvec3 position_{0.0};
    glm::dmat3 world_from_optical_{1.0};
    double focal_px_ = 1;
    glm::dvec2 middle_{0.0};
};

/// Where a ray meets the horizontal plane at a height; none when it goes away from it or along it.
std::optional<glm::dvec3> meet_plane(const Ray& ray, double height_m);
/// The height over a point's place on the ground at which a ray passes it nearest.
double height_beside(const Ray& ray, const glm::dvec3& point);
/// The point of a ray that is `distance_m` from a centre and nearest to `present`; where the ray passes by farther out,
/// the direction to its nearest point at that distance.
glm::dvec3 meet_sphere(const Ray& ray, const glm::dvec3& centre, double distance_m, const glm::dvec3& present);

}  // namespace camrig::view
