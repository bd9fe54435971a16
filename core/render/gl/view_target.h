#pragma once

#include "core/base/image_size.h"
#include "core/base/result.h"
#include "core/render/gl/gl_objects.h"

namespace camrig {

/// Colour and depth of one camera. The colour texture is sRGB: shaders write encoded values with GL_FRAMEBUFFER_SRGB
/// off, and only blending turns it on. Depth is 32-bit float, reversed.
struct ColorTarget {
    ImageSize size;
    GlTexture color;
    GlTexture depth;
    GlFramebuffer framebuffer;
};
Result<ColorTarget> make_color_target(const GlFunctions& gl, ImageSize size);

/// Ground truth of one camera: object numbers (R32UI), normals (RGBA32F), depth.
struct TruthTarget {
    ImageSize size;
    GlTexture instance;
    GlTexture normal;
    GlTexture depth;
    GlFramebuffer framebuffer;
};
Result<TruthTarget> make_truth_target(const GlFunctions& gl, ImageSize size);

}  // namespace camrig
