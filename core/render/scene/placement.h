#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/render/scene/light_selection.h"
#include "core/world/model.h"
#include "core/world/posed_model.h"
#include "core/world/snapshot.h"

/// Where the parts of a model are in the world, before any camera: the same for every way of drawing.
namespace camrig::render::scene {

/// What one joint of a skin moves: box of its vertices in the mesh's bind space.
struct JointBox {
    world::Box box;
    bool is_used = false;
};

/// Per joint index that the vertices use; empty without a skin.
std::vector<JointBox> joint_boxes_of(const world::Primitive& primitive);

world::Box bounds_of(std::span<const glm::vec3> points);
/// The box around a box that a matrix moves.
world::Box moved(const world::Box& box, const glm::dmat4& by);

/// Bounds of a skinned primitive without skinning it, in the model's frame. `use` gets what each joint moves of it: the
/// joint's node and a box.
template <typename Use>
world::Box skinned_bounds(const world::Model& model, const world::PosedModel& pose, int node,
                          std::span<const JointBox> boxes, const Use& use) {
    // A skinned vertex is a weighted mean of where its joints carry it, so it lies in the hull of the boxes of each
    // joint's own vertices, carried by that joint.
    const world::Skin& skin = model.skins[static_cast<std::size_t>(model.nodes[static_cast<std::size_t>(node)].skin)];
    world::Box bounds;
    bool is_empty = true;
    for (std::size_t j = 0; j < boxes.size(); ++j) {
        if (!boxes[j].is_used) continue;
        const auto joint = static_cast<std::size_t>(skin.joints[j]);
        const world::Box box = moved(boxes[j].box, pose.model_from_node[joint] * skin.inverse_bind[j]);
        use(skin.joints[j], box);
        bounds.min = is_empty ? box.min : glm::min(bounds.min, box.min);
        bounds.max = is_empty ? box.max : glm::max(bounds.max, box.max);
        is_empty = false;
    }
    return bounds;
}

/// The lights that shade what lies in the bounds.
LightSet lights_around(std::span<const world::Light> lights, float exposure, const glm::dmat4& world_from_local,
                       const world::Box& bounds);

/// Normals go with the cofactor matrix: right under non-uniform scale and defined even when the matrix is singular. Its
/// largest entry is 1; a mirroring turns it round.
glm::dmat3 normals_from(const glm::dmat4& optical_from_local, bool is_mirrored);

}  // namespace camrig::render::scene
