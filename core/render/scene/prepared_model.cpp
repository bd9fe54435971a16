#include "core/render/scene/prepared_model.h"

#include <algorithm>

#include "core/render/scene/detail_levels.h"

namespace camrig::render::scene {
namespace {

/// The default one of glTF where it names none.
const world::Material& material_of(const world::Model& model, const world::Primitive& primitive) {
    static const world::Material standard;
    return primitive.material < 0 ? standard : model.materials[static_cast<std::size_t>(primitive.material)];
}

}  // namespace

MeshLevel mesh_level(std::vector<std::uint32_t> indices, float error) {
    MeshLevel level{.triangles = {}, .vertices = {}, .error = error};
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        for (std::size_t c = 0; c < 3; ++c) level.triangles[c].push_back(indices[i + c]);
    }
    std::ranges::sort(indices);
    const auto repeated = std::ranges::unique(indices);
    indices.erase(repeated.begin(), repeated.end());
    level.vertices.assign(indices.begin(), indices.end());
    return level;
}

PreparedModel prepare_model(const world::ModelRef& model) {
    PreparedModel prepared;
    std::vector<std::size_t> first_of_mesh;
    for (const world::Mesh& mesh : model->meshes) {
        first_of_mesh.push_back(prepared.primitives.size());
        for (const world::Primitive& primitive : mesh.primitives) {
            const world::Material& material = material_of(*model, primitive);
            PreparedPrimitive& made = prepared.primitives.emplace_back();
            made.source = &primitive;
            made.material = &material;
            made.number = prepared.primitives.size() - 1;
            made.is_lit = !material.unlit && !primitive.normals.empty();
            made.is_blended = material.alpha_mode == world::AlphaMode::blend;
            for (DetailLevel& level : make_detail_levels(primitive))
                made.coarser.push_back(mesh_level(std::move(level.indices), level.error));
            made.joint_boxes = joint_boxes_of(primitive);
        }
    }
    for (const Surface& surface : draw_order(*model)) {
        const world::Node& node = model->nodes[static_cast<std::size_t>(surface.node)];
        const std::size_t number =
            first_of_mesh[static_cast<std::size_t>(node.mesh)] + static_cast<std::size_t>(surface.primitive);
        const PreparedPrimitive& primitive = prepared.primitives[number];
        prepared.surfaces.push_back(
            {.node = surface.node,
             .primitive = &primitive,
             .is_deformed = is_deformed(*model, surface.node),
             .is_skinned = node.skin >= 0 && primitive.source->targets.empty() && !primitive.source->joints.empty()});
    }
    prepared.body = body_of(*model);
    return prepared;
}

}  // namespace camrig::render::scene
