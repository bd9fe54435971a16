#pragma once

#include <map>
#include <tuple>

#include "core/render/gl/gl_objects.h"
#include "core/world/camera_spec.h"
#include "core/world/model.h"

namespace camrig::render::gl {

/// GL samplers by their settings.
class SamplerCache {
public:
    explicit SamplerCache(const GlFunctions& gl) : gl_(gl) {}
    /// As the file asks, except that `fast` and `simple` take the nearer mip level instead of blending two: trilinear
    /// filtering costs a CPU rasteriser a sixth of the whole frame.
    GLuint sampler(const world::Sampler& sampler, world::Quality quality);

private:
    const GlFunctions& gl_;
    std::map<std::tuple<world::Wrap, world::Wrap, GLint, GLint>, GlSampler> samplers_;
};

}  // namespace camrig::render::gl
