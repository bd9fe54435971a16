#pragma once

#include <vector>

#include <glm/glm.hpp>

namespace camrig::render {

/// Tables of the split-sum approximation (Karis, Real shading in Unreal Engine 4, 2013), the same for every scene. Rows
/// are roughness from 0 to 1, columns a cosine; both ends lie on texel centres.
inline constexpr int table_side = 32;
/// What a dielectric reflects of light that meets it squarely (glTF 2.0, appendix B).
inline constexpr float dielectric_f0 = 0.04f;

/// Per (n.v from 0 to 1, roughness): scale and bias of f0 in the share of uniform surroundings that a GGX surface
/// reflects, with Smith's visibility term as glTF 2.0 has it.
std::vector<glm::vec2> make_reflectance_table();

/// What of light from all around comes through a dielectric's surface to its base and back to a view at that cosine:
/// the mean of 1 - Fresnel's share at the half vectors, fitted within 0.0003. As in shaders/forward.frag. Of a float or
/// of several at once.
template <typename Number>
[[gnu::always_inline]] inline Number share_of_base(const Number& cosine) {
    const Number away = 1.0f - cosine, away2 = away * away;
    return (1.0f - dielectric_f0) * (1.0f - away2 * (0.0169f + 0.0111f * away2));
}

/// Per (height of the reflected ray from -1 to 1, roughness): share of the sky in what a GGX lobe around that ray sees
/// of surroundings with sky above, ground below and a soft horizon; the rest is ground. Scaled so that their irradiance
/// on a surface that faces up is the sky's alone, as that of hard-edged halves is; so it may leave 0..1 by up to 0.01.
std::vector<float> make_sky_table();

}  // namespace camrig::render
