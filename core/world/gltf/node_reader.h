#pragma once

#include "core/world/gltf/accessor_reader.h"
#include "core/world/model.h"

namespace camrig::world::gltf {

/// Fills nodes, order, skins, cameras and lights of a model whose meshes are there: the hierarchy is a forest of
/// bounded depth, every index exists, joints of a mesh are within the skin of its node. Throws Failure.
void read_nodes(const Document& document, const AccessorReader& accessors, Budget& budget, Model& model);

}  // namespace camrig::world::gltf
