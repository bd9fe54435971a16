#pragma once

#include "core/base/image_size.h"
#include "core/base/result.h"
#include "core/render/gl/gl_objects.h"

namespace camrig::render::gl {

/// Colour and depth of one picture. The colour texture is sRGB: shaders write encoded values with GL_FRAMEBUFFER_SRGB
/// off, and only blending turns it on. Depth is 32-bit float, reversed; a picture that is only resolved or warped into
/// has none.
struct ColorTarget {
    ImageSize size;
    int samples = 1;
    GlTexture color;
    GlTexture codes;  ///< the same pixels as integers (RGBA8UI); only where asked for
    GlTexture depth;
    GlFramebuffer framebuffer;
};
struct ColorTargetOptions {
    int samples = 1;
    bool has_depth = true;
    bool has_codes = false;
};
Result<ColorTarget> make_color_target(const GlFunctions& gl, ImageSize size, const ColorTargetOptions& options = {});

/// Ground truth of one picture: object numbers (R32UI), normals (RGBA32F), depth. What the scene is drawn into has a
/// depth buffer; what is warped into has the same values in a third colour attachment (R32F).
struct TruthTarget {
    ImageSize size;
    GlTexture instance;
    GlTexture normal;
    GlTexture depth;
    GlFramebuffer framebuffer;
    bool depth_is_color = false;
};
Result<TruthTarget> make_truth_target(const GlFunctions& gl, ImageSize size, bool depth_is_color = false);

/// Pictures have at most so many samples, of 8 bytes each.
inline constexpr std::int64_t max_target_samples = std::int64_t{1} << 27;

}  // namespace camrig::render::gl
