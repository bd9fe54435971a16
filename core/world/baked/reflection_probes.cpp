#include "core/world/baked/reflection_probes.h"

#include <cmath>

namespace camrig::world {
namespace {

/// The lower half of the octahedron lies around the upper one; each is the other's image.
glm::vec2 folded(const glm::vec2& at) {
    return {std::copysign(1.0f - std::abs(at.y), at.x), std::copysign(1.0f - std::abs(at.x), at.y)};
}

}  // namespace

glm::vec3 octahedral_direction(const glm::vec2& at) {
    const float z = 1.0f - std::abs(at.x) - std::abs(at.y);
    const glm::vec2 across = z < 0.0f ? folded(at) : at;
    return glm::normalize(glm::vec3(across, z));
}

glm::vec2 octahedral_place(const glm::vec3& direction) {
    const glm::vec2 at = glm::vec2(direction) / (std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z));
    return direction.z < 0.0f ? folded(at) : at;
}

}  // namespace camrig::world
