#pragma once

#include <optional>

#include <glm/glm.hpp>

namespace camrig::world {

/// `fog` of an environment: what is farther away has the fog's colour instead of its own, the more the farther.
struct FogSpec {
    double visibility_m = 0.0;         ///< where 2 % of a contrast are left; 0: no fog
    std::optional<glm::vec3> color{};  ///< of what is hidden all; nullopt: the background's
    friend bool operator==(const FogSpec&, const FogSpec&) = default;
};

/// The light of a place is weakened by exp(-per metre). H. Koschmieder, Theorie der horizontalen Sichtweite, 1924:
/// a contrast of 2 % is the least that is seen.
inline double extinction_per_m(const FogSpec& fog) {
    constexpr double of_visibility = 3.912;
    return fog.visibility_m > 0.0 ? of_visibility / fog.visibility_m : 0.0;
}

}  // namespace camrig::world
