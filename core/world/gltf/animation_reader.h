#pragma once

#include <vector>

#include "core/world/gltf/accessor_reader.h"
#include "core/world/model.h"

namespace camrig::world::gltf {

/// Animations of a model whose nodes are there: key times strictly rising, one output per key (three for cubic
/// splines), one channel per node and path, no channel on a node with a matrix. Throws Failure.
std::vector<Animation> read_animations(const Document& document, const AccessorReader& accessors, const Model& model);

}  // namespace camrig::world::gltf
