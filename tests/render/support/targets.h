#pragma once

#include <optional>
#include <vector>

#include "tests/render/support/test_rig.h"

namespace camrig::render {

/// How much the ray turns from this pixel to the next one, to the right and down; none where the lens shows nothing.
std::optional<glm::dvec2> ray_steps(const camera::CameraModel& camera, glm::dvec2 pixel);

/// A white disc that faces the camera, `distance` metres along the ray of `pixel`, about `radius_px` pixels large. Its
/// exact outline is known: the projection of `outline`.
struct Disc {
    glm::dvec3 centre{0.0};  ///< optical frame
    glm::dvec3 across{0.0};  ///< two axes of `radius` length in its plane
    glm::dvec3 up{0.0};
};
std::optional<Disc> disc_at(const camera::CameraModel& camera, glm::dvec2 pixel, double distance, double radius_px);

/// The discs as objects in front of a test camera (which looks along world +x from the origin).
TestWorld world_of(const std::vector<Disc>& discs);

/// Centre of the area of the disc's projection, from a dense polygon of its outline in double.
glm::dvec2 exact_centroid(const camera::CameraModel& camera, const Disc& disc);

/// Centre of light of the pixels around `near`, in linear light on black.
glm::dvec2 seen_centroid(const Picture& picture, glm::dvec2 near, double reach_px);

}  // namespace camrig::render
