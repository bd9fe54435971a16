#include "core/render/gl/shader_cache.h"

#include <spdlog/spdlog.h>

#include "core/render/gl/shader_program.h"
#include "core/render/gl/shader_sources.h"

namespace camrig {
namespace {

GlProgram must_build(const GlFunctions& gl, const char* name, const std::string& defines, const std::string& vertex,
                     const std::string& fragment) {
    auto program = build_program(gl, name, defines, vertex, fragment);
    if (!program) spdlog::critical("{}", program.error().message);
    CHECK(program.has_value());
    return std::move(*program);
}

}  // namespace

GLuint ShaderCache::program(const ShaderKey& wanted) {
    const ShaderKey key = simplified(wanted);
    const auto found = programs_.find(key);
    if (found != programs_.end()) return found->second.name();
    const std::string common = std::string(shader_source::blocks) + shader_source::lighting;
    GlProgram program = must_build(gl_, "forward", defines_of(key), common + shader_source::forward_vert,
                                   common + shader_source::shadow + shader_source::srgb + shader_source::forward_frag);
    return programs_.emplace(key, std::move(program)).first->second.name();
}

GLuint ShaderCache::shadow_program(bool masked, bool uv1, bool has_color, bool textured) {
    return depth_program("shadow", shadow_programs_, shader_source::shadow_vert, shader_source::shadow_frag, masked,
                         uv1, has_color, textured);
}

GLuint ShaderCache::truth_program(bool masked, bool uv1, bool has_color, bool textured) {
    return depth_program("truth", truth_programs_, shader_source::truth_vert, shader_source::truth_frag, masked, uv1,
                         has_color, textured);
}

GLuint ShaderCache::depth_program(const char* name, std::map<int, GlProgram>& programs, const char* vertex,
                                  const char* fragment, bool masked, bool uv1, bool has_color, bool textured) {
    const int key = masked ? 1 + 2 * uv1 + 4 * has_color + 8 * textured : 0;
    const auto found = programs.find(key);
    if (found != programs.end()) return found->second.name();
    std::string defines = "#define DIRECTIONAL_LIGHTS 0\n#define LOCAL_LIGHTS 0\n";
    if (masked) defines += "#define ALPHA_MASK\n";
    if (masked && textured) defines += "#define BASE_UV\n";
    if (masked && has_color) defines += "#define HAS_COLOR\n";
    defines += uv1 ? "#define UV0 in_uv1\n" : "#define UV0 in_uv0\n";
    GlProgram program = must_build(gl_, name, defines, std::string(shader_source::blocks) + vertex,
                                   std::string(shader_source::blocks) + fragment);
    return programs.emplace(key, std::move(program)).first->second.name();
}

}  // namespace camrig
