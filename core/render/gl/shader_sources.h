#pragma once

/// The texts of core/render/shaders, put into the program by CMake.
namespace camrig::render::gl::shader_source {
extern const char* const blocks;
extern const char* const lighting;
extern const char* const baked;
extern const char* const reflections;
extern const char* const contact;
extern const char* const shadow;
extern const char* const srgb;
extern const char* const tone_curve;
extern const char* const forward_vert;
extern const char* const forward_frag;
extern const char* const truth_vert;
extern const char* const truth_frag;
extern const char* const shadow_vert;
extern const char* const shadow_frag;
extern const char* const image_vert;
extern const char* const resolve_frag;
extern const char* const warp_color_frag;
extern const char* const warp_truth_frag;
extern const char* const convert_comp;
}  // namespace camrig::render::gl::shader_source
