#include "core/render/gl/beautiful_inputs.h"

#include "core/render/surface_tables.h"

namespace camrig::render::gl {
namespace {

constexpr GLuint shadow_unit = 5, reflectance_unit = 6, sky_unit = 7, light_map_unit = 8;

GlTexture upload(const GlFunctions& gl, GLenum storage, GLenum format, const void* values) {
    GlTexture texture = make_texture_2d(gl);
    gl.TextureStorage2D(texture.name(), 1, storage, table_side, table_side);
    gl.TextureSubImage2D(texture.name(), 0, 0, 0, table_side, table_side, format, GL_FLOAT, values);
    return texture;
}

GlSampler linear_sampler(const GlFunctions& gl, GLint wrap) {
    GlSampler sampler = make_sampler(gl);
    gl.SamplerParameteri(sampler.name(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.SamplerParameteri(sampler.name(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.SamplerParameteri(sampler.name(), GL_TEXTURE_WRAP_S, wrap);
    gl.SamplerParameteri(sampler.name(), GL_TEXTURE_WRAP_T, wrap);
    return sampler;
}

}  // namespace

BeautifulInputs::BeautifulInputs(const GlFunctions& gl)
    : gl_(gl),
      reflectance_(upload(gl, GL_RG32F, GL_RG, make_reflectance_table().data())),
      sky_(upload(gl, GL_R32F, GL_RED, make_sky_table().data())),
      table_sampler_(linear_sampler(gl, GL_CLAMP_TO_EDGE)),
      shadow_sampler_(linear_sampler(gl, GL_CLAMP_TO_BORDER)) {
    const GLuint shadow = shadow_sampler_.name();
    const GLfloat nothing_before[4] = {1.0f, 1.0f, 1.0f, 1.0f};
    gl.SamplerParameterfv(shadow, GL_TEXTURE_BORDER_COLOR, nothing_before);
    gl.SamplerParameteri(shadow, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl.SamplerParameteri(shadow, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
}

void BeautifulInputs::bind(GLuint shadow_maps, GLuint light_map) const {
    const auto use = [&](GLuint unit, GLuint texture, const GlSampler& sampler) {
        if (texture == 0) return;
        gl_.BindTextureUnit(unit, texture);
        gl_.BindSampler(unit, sampler.name());
    };
    use(reflectance_unit, reflectance_.name(), table_sampler_);
    use(sky_unit, sky_.name(), table_sampler_);
    use(shadow_unit, shadow_maps, shadow_sampler_);
    use(light_map_unit, light_map, table_sampler_);
}

}  // namespace camrig::render::gl
