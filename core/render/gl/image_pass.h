#pragma once

#include <map>

#include "core/render/gl/gl_objects.h"
#include "core/render/gl/lens_cache.h"
#include "core/render/gl/view_target.h"

namespace camrig::render::gl {

/// Makes pictures of pictures: resolves samples and looks through lenses. Every call draws one triangle over a whole
/// target and leaves DrawPass to set its state again (begin_instant).
class ImagePass {
public:
    /// `has_float_units`: the device's texture units filter with float weights (llvmpipe), not with 8 bits.
    ImagePass(const GlFunctions& gl, bool has_float_units);

    /// The mean of the samples of each pixel, in linear light: those of a multisampled source of the same size, or
    /// `supersampling` squared texels.
    void resolve(const ColorTarget& source, int supersampling, const ColorTarget& to);
    /// `source` has `supersampling` times the size of the plan's source; with more than 1 the filter is bilinear.
    void warp_color(const LensOnDevice& lens, const ColorTarget& source, int supersampling, bool is_bicubic,
                    const ColorTarget& to);
    /// Nearest texels; `to` has its depth as a colour.
    void warp_truth(const LensOnDevice& lens, const TruthTarget& source, const TruthTarget& to);
    void warp_depth(const LensOnDevice& lens, const ColorTarget& source, const TruthTarget& to);

private:
    struct Input {
        GLuint unit;
        GLuint texture;
        bool is_filtered = false;
    };
    void draw(GLuint program, GLuint framebuffer, ImageSize size, std::initializer_list<Input> inputs);
    GLuint program(const std::string& defines, const std::string& fragment);

    const GlFunctions& gl_;
    GlVertexArray no_vertices_;
    bool has_float_units_;
    GlSampler nearest_;
    GlSampler linear_;
    std::map<std::string, GlProgram> programs_;  ///< by defines
};

}  // namespace camrig::render::gl
