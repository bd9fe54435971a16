#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <string>

#include "core/render/gl/uniform_blocks.h"
#include "core/world/camera_spec.h"
#include "core/world/model.h"

namespace camrig::render::gl {

/// The textures a material can have, in the order of their texture units.
enum class TextureUse : std::uint8_t { base_color, emissive, occlusion, normal, metallic_roughness };
inline constexpr int texture_use_count = 5;

/// Where light from all around comes from: of sky and ground by the normal, from the map of baked light, or from a
/// place of it.
enum class LightAround : std::uint8_t { hemisphere, map, surroundings };

/// Which shader a draw needs: what its material and vertices have and how many lights reach it, never more. Equal keys
/// share a program.
struct ShaderKey {
    world::Quality quality = world::Quality::simple;
    world::AlphaMode alpha_mode = world::AlphaMode::opaque;
    bool lit = true;  ///< not unlit, and the vertices have normals
    bool double_sided = false;
    bool has_color = false;
    bool has_tangent = false;
    std::uint8_t uv_sets = 0;  ///< bit i: slot i reads texture coordinate 1
    std::array<std::int8_t, texture_use_count> uv_slots{-1, -1, -1, -1, -1};  ///< per TextureUse; -1: no such texture
    std::uint8_t directional_lights = 0;
    std::uint8_t local_lights = 0;
    bool has_shadows = false;  ///< one of the lights has a shadow map
    bool has_fog = false;
    LightAround light_around = LightAround::hemisphere;
    bool batched = false;  ///< several draws at once (DrawPass)
    friend auto operator<=>(const ShaderKey&, const ShaderKey&) = default;
};

/// Drops from a key what its quality does not draw, and rounds light counts up to those that shaders are made for (the
/// missing ones are black). Fewer different shaders, same picture.
ShaderKey simplified(ShaderKey key);

/// Light counts of `simplified` keys.
int rounded_directional(int count);
int rounded_local(int count);

/// First lines of a shader that draws several surfaces at once, or none.
std::string batch_defines(bool batched);

/// `#define` lines of shaders/forward.*.
std::string defines_of(const ShaderKey& key);

}  // namespace camrig::render::gl
