#pragma once

#include <vector>

#include "core/world/gltf/accessor_reader.h"
#include "core/world/model.h"

namespace camrig::world::gltf {

/// Reads all meshes: lists of points, lines or triangles with unit normals, normalised weights (the four strongest
/// joints of a vertex) and morph targets. Primitives that draw nothing are left out. Throws Failure.
std::vector<Mesh> read_meshes(const Document& document, const AccessorReader& accessors, Budget& budget);

}  // namespace camrig::world::gltf
