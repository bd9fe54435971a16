#pragma once

#include <vector>

#include <glm/glm.hpp>

namespace camrig::render {

/// Tables of the split-sum approximation (Karis, Real shading in Unreal Engine 4, 2013), the same for every scene. Rows
/// are roughness from 0 to 1, columns a cosine; both ends lie on texel centres.
inline constexpr int table_side = 32;

/// Per (n.v from 0 to 1, roughness): scale and bias of f0 in the share of uniform surroundings that a GGX surface
/// reflects; the shader's own visibility term.
std::vector<glm::vec2> make_reflectance_table();

/// Per (height of the reflected ray from -1 to 1, roughness): share of the sky in what a GGX lobe around that ray sees
/// of surroundings with sky above, ground below and a soft horizon; the rest is ground. Scaled so that their irradiance
/// on a surface that faces up is the sky's alone, as that of hard-edged halves is; so it may leave 0..1 by up to 0.01.
std::vector<float> make_sky_table();

}  // namespace camrig::render
