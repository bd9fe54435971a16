#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/render/scene/body_capsules.h"
#include "core/render/scene/draw_order.h"
#include "core/render/scene/model_cache.h"
#include "core/render/scene/placement.h"
#include "core/world/model.h"

namespace camrig::render::scene {

/// The corners of triangles: all first ones, all second ones, all third ones.
using TriangleCorners = std::array<std::vector<std::uint32_t>, 3>;

/// The triangles of a level of detail and the vertices that they use, rising.
struct MeshLevel {
    TriangleCorners triangles;
    std::vector<std::uint32_t> vertices;
    float error = 0.0f;  ///< as of DetailLevel; 0: the full mesh
};
MeshLevel mesh_level(std::vector<std::uint32_t> indices, float error);

/// One draw of a mesh, with its material. Points into the Model.
struct PreparedPrimitive {
    const world::Primitive* source = nullptr;
    const world::Material* material = nullptr;
    std::size_t number = 0;  ///< among all primitives of the model
    bool is_lit = false;
    bool is_blended = false;
    std::vector<MeshLevel> coarser;     ///< than the full mesh, each with a larger error than the one before
    std::vector<JointBox> joint_boxes;  ///< per joint index that vertices use; empty without a skin
};

/// A primitive at a node.
struct PreparedSurface {
    int node = 0;
    const PreparedPrimitive* primitive = nullptr;
    bool is_deformed = false;  ///< by a skin or morph targets
    bool is_skinned = false;   ///< and by nothing else
};

/// A Model as every way of drawing needs it: what follows from it before it is anywhere. Made once for all.
struct PreparedModel {
    std::vector<PreparedPrimitive> primitives;  ///< mesh after mesh
    std::vector<PreparedSurface> surfaces;      ///< as they are drawn
    std::vector<JointCapsule> body;             ///< of its skins
};
PreparedModel prepare_model(const world::ModelRef& model);

using PreparedModels = ModelCache<PreparedModel>;

}  // namespace camrig::render::scene
