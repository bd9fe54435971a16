#include "core/render/scene/draw_order.h"

#include <algorithm>
#include <utility>

namespace camrig::render::scene {

VertexLayout vertex_layout(const world::Primitive& primitive) {
    return {.topology = primitive.topology,
            .has_narrow_indices = primitive.positions.size() <= 0xFFFF,
            .has_normals = !primitive.normals.empty(),
            .has_tangents = !primitive.tangents.empty(),
            .has_texcoords = {!primitive.texcoords[0].empty(), !primitive.texcoords[1].empty()},
            .has_colors = !primitive.colors.empty()};
}

std::vector<Surface> draw_order(const world::Model& model) {
    const auto primitives_of = [&](int node) -> const std::vector<world::Primitive>& {
        static const std::vector<world::Primitive> none;
        const int mesh = model.nodes[static_cast<std::size_t>(node)].mesh;
        return mesh < 0 ? none : model.meshes[static_cast<std::size_t>(mesh)].primitives;
    };
    std::vector<Surface> surfaces;
    for (const int node : model.order) {
        const auto count = static_cast<int>(primitives_of(node).size());
        for (int i = 0; i < count; ++i) surfaces.push_back({node, i});
    }
    std::ranges::stable_sort(surfaces, {}, [&](const Surface& surface) {
        const world::Primitive& primitive = primitives_of(surface.node)[static_cast<std::size_t>(surface.primitive)];
        return std::pair(vertex_layout(primitive), primitive.material);
    });
    return surfaces;
}

}  // namespace camrig::render::scene
