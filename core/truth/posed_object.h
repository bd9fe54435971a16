#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/world/posed_model.h"
#include "core/world/snapshot.h"

namespace camrig::truth {

/// The surface of one object at one instant: what ground truth measures. Vertices in the object's own frame (its
/// heading's: x ahead for actors), metres, scale applied; surfaces with alpha mode BLEND, and what its look hides, are
/// left out.
///
/// Reused from object to object, so that nothing is allocated once it has grown.
class PosedObject {
public:
    struct Ball {
        glm::dvec3 center{0.0};
        double radius = -1.0;
    };
    struct Part {
        const world::Primitive* primitive = nullptr;
        std::vector<glm::dvec3> points;  ///< one per vertex of the primitive
    };

    /// Places the nodes only: enough for reach().
    void pose(const world::Instance& instance);
    /// A ball in the object's own frame that holds all of its surface; generous for skinned meshes. None where that
    /// cannot be told without the vertices (morph targets); a radius below 0 when there is no surface.
    std::optional<Ball> reach() const;
    /// After pose(): places the vertices. What follows is of them, but for the last.
    void place_vertices();

    std::span<const Part> parts() const { return {parts_.data(), part_count_}; }
    /// Its box, when it is not empty.
    glm::dvec3 min() const { return min_; }
    glm::dvec3 max() const { return max_; }
    bool is_empty() const { return part_count_ == 0; }
    /// The nodes of the pose, in the object's own frame.
    glm::dvec3 place_of_node(std::size_t node) const;

    /// world_from_object: its orientation without the turn that is the model's own.
    glm::dquat orientation() const { return orientation_; }
    glm::dvec3 position() const { return position_; }

private:
    template <typename Visit>
    void for_each_surface(Visit&& visit) const;
    void add_part(const world::Primitive& primitive, int node);

    world::ModelRef model_;
    std::shared_ptr<const world::ObjectInfo> info_;
    world::PosedModel pose_;
    std::vector<Part> parts_;
    std::size_t part_count_ = 0;
    std::vector<glm::vec3> positions_, normals_;
    glm::dmat3 object_from_model_{1.0};
    glm::dquat orientation_{1.0, 0.0, 0.0, 0.0};
    glm::dvec3 position_{0.0};
    glm::dvec3 min_{0.0}, max_{0.0};
};

}  // namespace camrig::truth
