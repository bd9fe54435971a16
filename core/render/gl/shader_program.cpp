#include "core/render/gl/shader_program.h"

#include <array>
#include <span>
#include <utility>

namespace camrig::render::gl {
namespace {

constexpr GLsizei max_log_bytes = 4096;

Result<GlShader> compile(const GlFunctions& gl, GLenum stage, std::string_view name, std::string_view defines,
                         std::string_view source) {
    constexpr std::string_view version = "#version 450 core\n";
    GlShader shader(gl, gl.CreateShader(stage));
    const std::array<const char*, 3> parts{version.data(), defines.data(), source.data()};
    const std::array<GLint, 3> lengths{static_cast<GLint>(version.size()), static_cast<GLint>(defines.size()),
                                       static_cast<GLint>(source.size())};
    gl.ShaderSource(shader.name(), 3, parts.data(), lengths.data());
    gl.CompileShader(shader.name());
    GLint ok = GL_FALSE;
    gl.GetShaderiv(shader.name(), GL_COMPILE_STATUS, &ok);
    if (ok == GL_TRUE) return shader;

    std::string log(max_log_bytes, '\0');
    GLsizei length = 0;
    gl.GetShaderInfoLog(shader.name(), max_log_bytes, &length, log.data());
    log.resize(static_cast<std::size_t>(length));
    const char* const ending = stage == GL_VERTEX_SHADER ? ".vert" : stage == GL_FRAGMENT_SHADER ? ".frag" : ".comp";
    return error(ErrorKind::internal,
                 std::string(name) + ending + " does not compile with\n" + std::string(defines) + log);
}

Result<GlProgram> link(const GlFunctions& gl, std::string_view name, std::string_view defines,
                       std::span<const GlShader> shaders) {
    GlProgram program(gl, gl.CreateProgram());
    for (const GlShader& shader : shaders) gl.AttachShader(program.name(), shader.name());
    gl.LinkProgram(program.name());
    GLint ok = GL_FALSE;
    gl.GetProgramiv(program.name(), GL_LINK_STATUS, &ok);
    if (ok == GL_TRUE) return program;

    std::string log(max_log_bytes, '\0');
    GLsizei length = 0;
    gl.GetProgramInfoLog(program.name(), max_log_bytes, &length, log.data());
    log.resize(static_cast<std::size_t>(length));
    return error(ErrorKind::internal, std::string(name) + " does not link with\n" + std::string(defines) + log);
}

}  // namespace

Result<GlProgram> build_program(const GlFunctions& gl, std::string_view name, std::string_view defines,
                                std::string_view vertex_source, std::string_view fragment_source) {
    auto vertex = compile(gl, GL_VERTEX_SHADER, name, defines, vertex_source);
    if (!vertex) return std::unexpected(vertex.error());
    auto fragment = compile(gl, GL_FRAGMENT_SHADER, name, defines, fragment_source);
    if (!fragment) return std::unexpected(fragment.error());
    return link(gl, name, defines, std::array{std::move(*vertex), std::move(*fragment)});
}

Result<GlProgram> build_compute_program(const GlFunctions& gl, std::string_view name, std::string_view defines,
                                        std::string_view source) {
    auto compute = compile(gl, GL_COMPUTE_SHADER, name, defines, source);
    if (!compute) return std::unexpected(compute.error());
    return link(gl, name, defines, std::array{std::move(*compute)});
}

}  // namespace camrig::render::gl
