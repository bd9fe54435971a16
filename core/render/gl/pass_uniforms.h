#pragma once

#include <cstddef>

#include "core/render/gl/pass_view.h"
#include "core/render/gl/uniform_blocks.h"

/// The uniform blocks of a picture and its draws: values alone, without a call of GL.
namespace camrig::render::gl {

ViewBlock view_block(const PassView& view);
ShadowBlock shadow_block(const PassView& view);
DrawBlock draw_block(const scene::SeenSurface& seen);
/// For a shadow map: four rows of a matrix, the last in normal_rows[0] (shaders/shadow.vert).
DrawBlock shadow_draw_block(const glm::dmat4& clip_from_local);

/// Which of the view's shadow maps the light has; below 0: none.
float shadow_slot(const PassView& view, std::size_t light);

/// Bytes of the lights of a draw in the layout of shaders/blocks.glsl; 0: unlit.
std::size_t light_bytes(const PassView& view, const scene::LightSet& set);
void write_lights(const PassView& view, const scene::LightSet& set, std::byte* to);

}  // namespace camrig::render::gl
