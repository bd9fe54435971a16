#include "core/render/gl/shader_cache.h"

#include <spdlog/spdlog.h>

#include "core/render/gl/shader_program.h"
#include "core/render/gl/shader_sources.h"

namespace camrig::render::gl {
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
                                   common + shader_source::baked + shader_source::reflections + shader_source::contact +
                                       shader_source::shadow + shader_source::srgb + shader_source::tone_curve +
                                       shader_source::forward_frag);
    return programs_.emplace(key, std::move(program)).first->second.name();
}

GLuint ShaderCache::shadow_program(DepthKey key) {
    return depth_program("shadow", shadow_programs_, shader_source::shadow_vert, shader_source::shadow_frag, key);
}

GLuint ShaderCache::truth_program(DepthKey key) {
    return depth_program("truth", truth_programs_, shader_source::truth_vert, shader_source::truth_frag, key);
}

GLuint ShaderCache::depth_program(const char* name, DepthPrograms& programs, const char* vertex, const char* fragment,
                                  DepthKey key) {
    if (!key.masked) key = {.batched = key.batched};
    const auto found = programs.find(key);
    if (found != programs.end()) return found->second.name();
    std::string defines = batch_defines(key.batched);
    defines += "#define DIRECTIONAL_LIGHTS 0\n#define LOCAL_LIGHTS 0\n";
    if (key.masked) defines += "#define ALPHA_MASK\n";
    if (key.textured) defines += "#define BASE_UV\n";
    if (key.has_color) defines += "#define HAS_COLOR\n";
    defines += key.uv1 ? "#define UV0 in_uv1\n" : "#define UV0 in_uv0\n";
    GlProgram program = must_build(gl_, name, defines, std::string(shader_source::blocks) + vertex,
                                   std::string(shader_source::blocks) + fragment);
    return programs.emplace(key, std::move(program)).first->second.name();
}

}  // namespace camrig::render::gl
