#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/bake/ray_scene.h"

/// Surfaces that shine brighter than white: lamps. They are small, and rays to all sides would meet them by chance;
/// so rays are sent to them.
namespace camrig::bake {

class AreaLamps {
public:
    /// The scene must stay.
    explicit AreaLamps(const RayScene& scene);

    bool empty() const { return triangles_.empty(); }
    static bool is_lamp(const RaySurface& surface);

    /// About how bright each triangle would be at a place if nothing was in its way, as sums up to each: by these one
    /// is chosen. Of each that sends any light there it is more than 0. normal: of the place; 0: from all sides.
    void weigh(const glm::vec3& place, const glm::vec3& normal, bool both_sides, std::vector<float>& sums) const;

    /// A point of a lamp, as a place near the one that was weighed has its light.
    struct Sample {
        glm::vec3 towards{0.0f};  ///< unit
        float distance = 0.0f;
        glm::vec3 light{0.0f};  ///< in units of shading, for a surface that faces it, over the chance to be chosen
    };
    /// at: of a unit square. nullopt: nothing of it arrives.
    std::optional<Sample> sample(const std::vector<float>& sums, const glm::vec3& place, glm::vec2 at) const;

private:
    struct Triangle {
        std::uint32_t surface = 0, number = 0;
        bool both_sides = false;
        std::array<glm::vec3, 3> corners{};
        glm::vec3 middle{0.0f}, side{0.0f};
        float area = 0.0f, power = 0.0f;
    };
    const RayScene& scene_;
    std::vector<Triangle> triangles_;
};

}  // namespace camrig::bake
