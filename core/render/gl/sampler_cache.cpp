#include "core/render/gl/sampler_cache.h"

namespace camrig::render::gl {
namespace {

GLint gl_wrap(world::Wrap wrap) {
    switch (wrap) {
        case world::Wrap::repeat:
            return GL_REPEAT;
        case world::Wrap::clamp_to_edge:
            return GL_CLAMP_TO_EDGE;
        case world::Wrap::mirrored_repeat:
            return GL_MIRRORED_REPEAT;
    }
    return GL_REPEAT;
}

GLint gl_minify(const world::Sampler& sampler, world::Quality quality) {
    const bool linear = sampler.minify == world::Filter::linear;
    if (!sampler.mipmaps) return linear ? GL_LINEAR : GL_NEAREST;
    const bool between = sampler.between_mipmaps == world::Filter::linear && quality == world::Quality::beautiful;
    if (linear) return between ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR_MIPMAP_NEAREST;
    return between ? GL_NEAREST_MIPMAP_LINEAR : GL_NEAREST_MIPMAP_NEAREST;
}

}  // namespace

GLuint SamplerCache::sampler(const world::Sampler& wanted, world::Quality quality) {
    const GLint minify = gl_minify(wanted, quality);
    const GLint magnify = wanted.magnify == world::Filter::linear ? GL_LINEAR : GL_NEAREST;
    GlSampler& sampler = samplers_[{wanted.wrap_s, wanted.wrap_t, minify, magnify}];
    if (!sampler) {
        sampler = make_sampler(gl_);
        gl_.SamplerParameteri(sampler.name(), GL_TEXTURE_WRAP_S, gl_wrap(wanted.wrap_s));
        gl_.SamplerParameteri(sampler.name(), GL_TEXTURE_WRAP_T, gl_wrap(wanted.wrap_t));
        gl_.SamplerParameteri(sampler.name(), GL_TEXTURE_MIN_FILTER, minify);
        gl_.SamplerParameteri(sampler.name(), GL_TEXTURE_MAG_FILTER, magnify);
    }
    return sampler.name();
}

}  // namespace camrig::render::gl
