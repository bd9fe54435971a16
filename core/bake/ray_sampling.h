#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <glm/glm.hpp>

#include "core/base/random.h"

/// Which ways rays go.
namespace camrig::bake {

/// Two axes across a unit vector. Duff et al., Building an orthonormal basis, revisited, 2017.
struct Basis {
    glm::vec3 right, down, ahead;
    explicit Basis(const glm::vec3& n) : ahead(n) {
        const float sign = std::copysign(1.0f, n.z), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
        right = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
        down = {b, sign + n.y * n.y * a, -n.y};
    }
    glm::vec3 turned(const glm::vec3& v) const { return right * v.x + down * v.y + ahead * v.z; }
};

/// Points of a unit square that are spread evenly, moved by a shift: Roberts, The unreasonable effectiveness of
/// quasirandom sequences, 2018.
inline glm::vec2 spread_point(int i, const glm::vec2& shift) {
    const glm::dvec2 at(0.7548776662466927 * i + shift.x, 0.5698402909980532 * i + shift.y);
    return glm::vec2(at - glm::floor(at));
}
inline glm::vec3 by_cosine(const glm::vec2& at) {
    const float radius = std::sqrt(at.x), angle = 2.0f * std::numbers::pi_v<float> * at.y;
    return {radius * std::cos(angle), radius * std::sin(angle), std::sqrt(std::max(0.0f, 1.0f - at.x))};
}
inline glm::vec3 to_all_sides(const glm::vec2& at) {
    const float z = 1.0f - 2.0f * at.x, radius = std::sqrt(std::max(0.0f, 1.0f - z * z));
    const float angle = 2.0f * std::numbers::pi_v<float> * at.y;
    return {radius * std::cos(angle), radius * std::sin(angle), z};
}
inline glm::vec2 shift_of(std::uint64_t stream, std::uint64_t number) {
    return {static_cast<float>(random_unit(stream, number, 0)), static_cast<float>(random_unit(stream, number, 1))};
}

}  // namespace camrig::bake
