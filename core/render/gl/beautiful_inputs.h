#pragma once

#include "core/render/gl/gl_objects.h"

namespace camrig::render::gl {

/// What shaders of quality `beautiful` read besides their materials: the tables of the split sum, and shadow maps. Made
/// when the first such picture is drawn.
class BeautifulInputs {
public:
    explicit BeautifulInputs(const GlFunctions& gl);
    /// To the texture units that shaders/forward.frag names; shadow_maps 0: there are none.
    void bind(GLuint shadow_maps) const;

private:
    const GlFunctions& gl_;
    GlTexture reflectance_, sky_;
    GlSampler table_sampler_, shadow_sampler_;
};

}  // namespace camrig::render::gl
