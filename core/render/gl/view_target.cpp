#include "core/render/gl/view_target.h"

namespace camrig::render::gl {
namespace {

GlTexture storage(const GlFunctions& gl, GLenum format, ImageSize size, int samples = 1) {
    if (samples > 1) {
        GlTexture texture = make_texture(gl, GL_TEXTURE_2D_MULTISAMPLE);
        gl.TextureStorage2DMultisample(texture.name(), samples, format, size.width, size.height, GL_TRUE);
        return texture;
    }
    GlTexture texture = make_texture_2d(gl);
    gl.TextureStorage2D(texture.name(), 1, format, size.width, size.height);
    return texture;
}

Result<void> check_complete(const GlFunctions& gl, const GlFramebuffer& framebuffer, ImageSize size) {
    if (gl.CheckNamedFramebufferStatus(framebuffer.name(), GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return {};
    is_out_of_memory(gl);  // said here: whoever asks next asks for something else
    return error(ErrorKind::resource_exhausted, "no memory on the device for a picture of " + size.to_string());
}

}  // namespace

Result<ColorTarget> make_color_target(const GlFunctions& gl, ImageSize size, const ColorTargetOptions& options) {
    ColorTarget target{.size = size,
                       .samples = options.samples,
                       .color = storage(gl, GL_SRGB8_ALPHA8, size, options.samples),
                       .codes = {},
                       .depth = {},
                       .framebuffer = make_framebuffer(gl)};
    const GLuint framebuffer = target.framebuffer.name();
    gl.NamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, target.color.name(), 0);
    if (options.has_codes) {
        CHECK(options.samples == 1);
        target.codes = make_texture_view(gl, target.color, GL_RGBA8UI);
    }
    if (options.has_depth) {
        target.depth = storage(gl, GL_DEPTH_COMPONENT32F, size, options.samples);
        gl.NamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, target.depth.name(), 0);
    }
    if (auto complete = check_complete(gl, target.framebuffer, size); !complete) {
        return std::unexpected(complete.error());
    }
    return target;
}

Result<TruthTarget> make_truth_target(const GlFunctions& gl, ImageSize size, bool depth_is_color) {
    TruthTarget target{.size = size,
                       .instance = storage(gl, GL_R32UI, size),
                       .normal = storage(gl, GL_RGBA32F, size),
                       .depth = storage(gl, depth_is_color ? GL_R32F : GL_DEPTH_COMPONENT32F, size),
                       .framebuffer = make_framebuffer(gl),
                       .depth_is_color = depth_is_color};
    const GLuint framebuffer = target.framebuffer.name();
    gl.NamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, target.instance.name(), 0);
    gl.NamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT1, target.normal.name(), 0);
    gl.NamedFramebufferTexture(framebuffer, depth_is_color ? GL_COLOR_ATTACHMENT2 : GL_DEPTH_ATTACHMENT,
                               target.depth.name(), 0);
    const GLenum buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
    gl.NamedFramebufferDrawBuffers(framebuffer, depth_is_color ? 3 : 2, buffers);
    if (auto complete = check_complete(gl, target.framebuffer, size); !complete) {
        return std::unexpected(complete.error());
    }
    return target;
}

}  // namespace camrig::render::gl
