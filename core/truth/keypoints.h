#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include <glm/glm.hpp>

namespace camrig::truth {

/// The 17 body points of COCO (person keypoints), in COCO's order; a model names its nodes so by `extras.keypoint`.
inline constexpr std::array<std::string_view, 17> coco_keypoints{
    "nose",           "left_eye",   "right_eye",   "left_ear",   "right_ear",   "left_shoulder",
    "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist", "left_hip",
    "right_hip",      "left_knee",  "right_knee",  "left_ankle", "right_ankle"};

enum class KeypointVisibility : std::uint8_t { outside = 0, occluded = 1, visible = 2 };

struct Keypoint {
    bool is_known = false;   ///< false: the model has no such point
    bool has_pixel = false;  ///< false: no pixel stands for it (behind the camera, outside of the lens's field)
    glm::dvec2 pixel{0.0};   ///< OpenCV's continuous coordinates; may be outside of the picture
    glm::dvec3 world{0.0};
    KeypointVisibility visibility = KeypointVisibility::outside;
};

/// How far behind the visible surface of its own body a point still counts as visible, metres at scale 1. The points of
/// the face lie on the skin; joints lie inside the body, up to 0.13 m below the cloth in our people (a hip).
double keypoint_tolerance_m(std::size_t coco_index);

}  // namespace camrig::truth
