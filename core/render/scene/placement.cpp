#include "core/render/scene/placement.h"

#include <algorithm>
#include <cmath>

namespace camrig::render::scene {
namespace {

glm::vec3 extent_along(const glm::dmat4& m, glm::dvec3 half) {
    return glm::vec3(glm::abs(glm::dvec3(m[0])) * half.x + glm::abs(glm::dvec3(m[1])) * half.y +
                     glm::abs(glm::dvec3(m[2])) * half.z);
}

}  // namespace

std::vector<JointBox> joint_boxes_of(const world::Primitive& primitive) {
    std::vector<JointBox> boxes;
    for (std::size_t v = 0; v < primitive.joints.size(); ++v) {
        for (int k = 0; k < 4; ++k) {
            if (!(primitive.weights[v][k] > 0.0f)) continue;
            const std::size_t joint = primitive.joints[v][k];
            if (joint >= boxes.size()) boxes.resize(joint + 1);
            JointBox& entry = boxes[joint];
            const glm::vec3 point = primitive.positions[v];
            entry.box.min = entry.is_used ? glm::min(entry.box.min, point) : point;
            entry.box.max = entry.is_used ? glm::max(entry.box.max, point) : point;
            entry.is_used = true;
        }
    }
    return boxes;
}

world::Box bounds_of(std::span<const glm::vec3> points) {
    world::Box box{points.front(), points.front()};
    for (const glm::vec3& point : points) {
        box.min = glm::min(box.min, point);
        box.max = glm::max(box.max, point);
    }
    return box;
}

world::Box moved(const world::Box& box, const glm::dmat4& by) {
    const glm::vec3 centre(by * glm::dvec4(0.5 * (glm::dvec3(box.min) + glm::dvec3(box.max)), 1.0));
    const glm::vec3 half = extent_along(by, 0.5 * (glm::dvec3(box.max) - glm::dvec3(box.min)));
    return {centre - half, centre + half};
}

LightSet lights_around(std::span<const world::Light> lights, float exposure, const glm::dmat4& world_from_local,
                       const world::Box& bounds) {
    const glm::dvec3 half = 0.5 * (glm::dvec3(bounds.max) - glm::dvec3(bounds.min));
    const glm::dvec3 centre = 0.5 * (glm::dvec3(bounds.max) + glm::dvec3(bounds.min));
    return select_lights(lights, exposure, glm::dvec3(world_from_local * glm::dvec4(centre, 1.0)),
                         glm::length(extent_along(world_from_local, half)));
}

glm::dmat3 normals_from(const glm::dmat4& optical_from_local, bool is_mirrored) {
    const glm::dmat3 m(optical_from_local);
    glm::dmat3 cofactor(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
    double largest = 0.0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) largest = std::max(largest, std::abs(cofactor[i][j]));
    }
    if (largest > 0.0) cofactor *= (is_mirrored ? -1.0 : 1.0) / largest;
    return cofactor;
}

}  // namespace camrig::render::scene
