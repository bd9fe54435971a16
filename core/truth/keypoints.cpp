#include "core/truth/keypoints.h"

namespace camrig::truth {

double keypoint_tolerance_m(std::size_t coco_index) {
    constexpr std::size_t face_points = 5;
    return coco_index < face_points ? 0.05 : 0.15;
}

}  // namespace camrig::truth
