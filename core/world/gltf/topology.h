#pragma once

#include <cstdint>
#include <vector>

#include "core/world/model.h"

namespace camrig::world::gltf {

/// The seven primitive modes of glTF 2.0, 3.7.2.1, by their numbers.
enum class Mode : int { points, lines, line_loop, line_strip, triangles, triangle_strip, triangle_fan };

Topology topology_of(Mode mode);

/// Turns strips, loops and fans into lists, with the winding the standard gives; an incomplete last line or triangle is
/// dropped.
std::vector<std::uint32_t> to_list(Mode mode, std::vector<std::uint32_t> indices);

/// Gives every triangle vertices of its own and one normal (glTF 2.0, 3.7.2.1: no normals means flat shading). A
/// triangle without area gets +y.
void make_flat(Primitive& primitive);

}  // namespace camrig::world::gltf
