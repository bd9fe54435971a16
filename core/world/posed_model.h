#pragma once

#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/world/model.h"

namespace camrig::world {

/// One animation clip at one moment. phase_ns is in [0, duration]; weights of all clips of an instance sum to 1.
struct ClipState {
    int animation = 0;
    TimeNs phase_ns = 0;
    double weight = 1.0;
    friend bool operator==(const ClipState&, const ClipState&) = default;
};

/// A model in one pose: every node's place in the model's own z-up frame (world_from_gltf applied). Double precision.
struct PosedModel {
    std::vector<glm::dmat4> model_from_node;        ///< per node; identity for nodes outside the default scene
    std::vector<std::vector<float>> morph_weights;  ///< per node; empty where the mesh has no targets
};

/// Evaluates clips (blended by weight; rotations along the shorter arc) over the rest pose. Pure function of its input,
/// nothing is accumulated. `out` is reused: no allocation once it has grown.
void pose_model(const Model& model, std::span<const ClipState> clips, PosedModel& out);

/// Whether deform_vertices turns triangles round: fronts are seen from behind. Of a skin by the first vertex's joints.
bool deforming_mirrors(const Model& model, const PosedModel& pose, int node, const Primitive& primitive);

/// Vertices of one primitive of a mesh node in the model's z-up frame, skinned and morphed: positions and unit normals
/// (cofactor matrix, so non-uniform scale is right). `node` must have a mesh. Spans are as long as the primitive's
/// positions. `which`: only these vertices; by default all.
void deform_vertices(const Model& model, const PosedModel& pose, int node, const Primitive& primitive,
                     std::span<glm::vec3> positions, std::span<glm::vec3> normals,
                     std::optional<std::span<const std::uint32_t>> which = std::nullopt);

/// True if the vertices of this node's mesh must be deformed on each pose (skin or morph targets); otherwise
/// model_from_node[node] moves them rigidly.
bool is_deformed(const Model& model, int node);

}  // namespace camrig::world
