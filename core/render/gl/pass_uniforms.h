#pragma once

#include <cstddef>
#include <span>

#include "core/render/gl/pass_view.h"
#include "core/render/gl/shader_key.h"
#include "core/render/gl/uniform_blocks.h"

/// The uniform blocks of a picture and its draws: values alone, without a call of GL.
namespace camrig::render::gl {

ViewBlock view_block(const PassView& view);
ShadowBlock shadow_block(const PassView& view);
DrawBlock draw_block(const scene::SeenSurface& seen);
/// Of a view with a map of baked light.
ReflectionBlock reflection_block(const PassView& view);
/// Of a draw whose light_around() is that.
SurroundingsBlock surroundings_block(const PassView& view, const scene::PlacedSurface& surface);
/// For a shadow map: four rows of a matrix, the last in normal_rows[0] (shaders/shadow.vert).
DrawBlock shadow_draw_block(const glm::dmat4& clip_from_local);

LightAround light_around(const PassView& view, const scene::PlacedSurface& surface);
/// Those that shine on it by themselves: lamps are in baked light.
scene::LightSet lights_of(const PassView& view, const scene::PlacedSurface& surface);

/// The view's shadow maps of the light.
std::span<const ShadowView> shadow_maps_of(const PassView& view, std::size_t light);

/// Bytes of the lights of a draw in the layout of shaders/blocks.glsl; 0: unlit.
std::size_t light_bytes(const PassView& view, const scene::LightSet& set);
void write_lights(const PassView& view, const scene::LightSet& set, std::byte* to);

}  // namespace camrig::render::gl
