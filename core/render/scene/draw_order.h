#pragma once

#include <compare>
#include <vector>

#include "core/world/model.h"

/// In which order the surfaces of a model are drawn, by every renderer: of two opaque ones in one plane the first is
/// seen.
namespace camrig::render::scene {

/// What a primitive has of vertices and indices. Those of equal layouts can be stored behind each other.
struct VertexLayout {
    world::Topology topology = world::Topology::triangles;
    bool has_narrow_indices = false;  ///< 16 bits
    bool has_normals = false;
    bool has_tangents = false;
    bool has_texcoords[2] = {};
    bool has_colors = false;
    friend auto operator<=>(const VertexLayout&, const VertexLayout&) = default;
};
VertexLayout vertex_layout(const world::Primitive& primitive);

/// A primitive of the mesh of a node.
struct Surface {
    int node = 0;
    int primitive = 0;
};
/// All surfaces of a model: those of one layout and material behind each other, so that they can be drawn at once, else
/// as in the file, parents before children.
std::vector<Surface> draw_order(const world::Model& model);

}  // namespace camrig::render::scene
