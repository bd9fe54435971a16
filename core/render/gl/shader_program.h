#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/render/gl/gl_objects.h"

namespace camrig::render::gl {

/// Compiles and links; both sources get `#version 450 core` and `defines` in front. Errors carry the driver's log and
/// `name`.
Result<GlProgram> build_program(const GlFunctions& gl, std::string_view name, std::string_view defines,
                                std::string_view vertex_source, std::string_view fragment_source);
Result<GlProgram> build_compute_program(const GlFunctions& gl, std::string_view name, std::string_view defines,
                                        std::string_view source);

}  // namespace camrig::render::gl
