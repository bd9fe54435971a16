#pragma once

#include <utility>

#include "core/render/gl/gl_functions.h"

namespace camrig::render::gl {

/// Owns one GL name; movable, deleted with its owner. The context must be current and outlive it.
template <typename Traits>
class GlObject {
public:
    GlObject() = default;
    GlObject(const GlFunctions& gl, GLuint name) : gl_(&gl), name_(name) {}
    GlObject(GlObject&& other) noexcept : gl_(other.gl_), name_(std::exchange(other.name_, 0)) {}
    GlObject& operator=(GlObject&& other) noexcept {
        std::swap(gl_, other.gl_);
        std::swap(name_, other.name_);
        return *this;
    }
    ~GlObject() {
        if (name_ != 0) Traits::destroy(*gl_, name_);
    }

    GLuint name() const { return name_; }
    explicit operator bool() const { return name_ != 0; }

private:
    const GlFunctions* gl_ = nullptr;
    GLuint name_ = 0;
};

namespace detail {
struct BufferTraits {
    static void destroy(const GlFunctions& gl, GLuint name) { gl.DeleteBuffers(1, &name); }
};
struct TextureTraits {
    static void destroy(const GlFunctions& gl, GLuint name) { gl.DeleteTextures(1, &name); }
};
struct FramebufferTraits {
    static void destroy(const GlFunctions& gl, GLuint name) { gl.DeleteFramebuffers(1, &name); }
};
struct VertexArrayTraits {
    static void destroy(const GlFunctions& gl, GLuint name) { gl.DeleteVertexArrays(1, &name); }
};
struct SamplerTraits {
    static void destroy(const GlFunctions& gl, GLuint name) { gl.DeleteSamplers(1, &name); }
};
struct ShaderTraits {
    static void destroy(const GlFunctions& gl, GLuint name) { gl.DeleteShader(name); }
};
struct ProgramTraits {
    static void destroy(const GlFunctions& gl, GLuint name) { gl.DeleteProgram(name); }
};
}  // namespace detail

using GlBuffer = GlObject<detail::BufferTraits>;
using GlTexture = GlObject<detail::TextureTraits>;
using GlFramebuffer = GlObject<detail::FramebufferTraits>;
using GlVertexArray = GlObject<detail::VertexArrayTraits>;
using GlSampler = GlObject<detail::SamplerTraits>;
using GlShader = GlObject<detail::ShaderTraits>;
using GlProgram = GlObject<detail::ProgramTraits>;

inline GlBuffer make_buffer(const GlFunctions& gl) {
    GLuint name = 0;
    gl.CreateBuffers(1, &name);
    return {gl, name};
}
inline GlTexture make_texture(const GlFunctions& gl, GLenum target) {
    GLuint name = 0;
    gl.CreateTextures(target, 1, &name);
    return {gl, name};
}
inline GlTexture make_texture_2d(const GlFunctions& gl) {
    return make_texture(gl, GL_TEXTURE_2D);
}
/// The memory of a plain 2D texture with one level, read in another format of the same size.
inline GlTexture make_texture_view(const GlFunctions& gl, const GlTexture& texture, GLenum format) {
    GLuint name = 0;
    gl.GenTextures(1, &name);  // not CreateTextures: a view needs a name that is no texture yet
    gl.TextureView(name, GL_TEXTURE_2D, texture.name(), format, 0, 1, 0, 1);
    return {gl, name};
}
inline GlFramebuffer make_framebuffer(const GlFunctions& gl) {
    GLuint name = 0;
    gl.CreateFramebuffers(1, &name);
    return {gl, name};
}
inline GlVertexArray make_vertex_array(const GlFunctions& gl) {
    GLuint name = 0;
    gl.CreateVertexArrays(1, &name);
    return {gl, name};
}
inline GlSampler make_sampler(const GlFunctions& gl) {
    GLuint name = 0;
    gl.CreateSamplers(1, &name);
    return {gl, name};
}

}  // namespace camrig::render::gl
