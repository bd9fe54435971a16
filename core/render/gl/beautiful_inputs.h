#pragma once

#include "core/render/gl/gl_objects.h"

namespace camrig::render::gl {

/// What shaders of quality `beautiful` read besides their materials: the tables of the split sum, shadow maps, and the
/// map of baked light. Made when the first such picture is drawn.
class BeautifulInputs {
public:
    explicit BeautifulInputs(const GlFunctions& gl);
    /// To the texture units that shaders/forward.frag and baked.glsl name; 0: there is none.
    void bind(GLuint shadow_maps, GLuint light_map) const;

private:
    const GlFunctions& gl_;
    GlTexture reflectance_, sky_;
    GlSampler table_sampler_, shadow_sampler_;  ///< that of tables reads the map of light, too
};

}  // namespace camrig::render::gl
