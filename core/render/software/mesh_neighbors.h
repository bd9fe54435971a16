#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/render/scene/prepared_model.h"

namespace camrig::render::software {

/// For each triangle of a mesh and each corner: the triangle beyond the edge opposite of that corner; -1: none, or
/// surfaces that do not go on smoothly (more than two triangles at one edge, corners that turn the other way).
using MeshNeighbors = std::vector<std::array<std::int32_t, 3>>;

/// Vertices with the same place, normal, colour, joints and movement count as one, whatever their texture coordinates:
/// what is one smooth surface has no edges inside.
MeshNeighbors neighbors_of(const scene::TriangleCorners& triangles, const world::Primitive& primitive);

}  // namespace camrig::render::software
