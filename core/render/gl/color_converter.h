#pragma once

#include <map>

#include "core/base/result.h"
#include "core/frame/pixel_format.h"
#include "core/render/gl/gl_objects.h"

namespace camrig::render::gl {

/// Colour conversion on the device, for pictures that are read back in the layout that readers take: fewer bytes on
/// their way to host memory, and none to convert there. The bytes are those of convert() (core/frame/convert.h).
class ColorConverter {
public:
    /// Builds all its shaders: none is built while the world runs.
    static Result<ColorConverter> create(const GlFunctions& gl);

    bool can_make(frame::PixelFormat format, ImageSize size) const;
    /// Writes the picture to `offset` of the buffer, whole words: up to 3 bytes more than it has. `codes`: its pixels
    /// as integers (ColorTarget::codes). `offset`: a multiple of 256. Leaves programs and bindings changed.
    void convert(GLuint codes, ImageSize size, frame::PixelFormat format, GLuint buffer, GLintptr offset);

private:
    explicit ColorConverter(const GlFunctions& gl);

    const GlFunctions& gl_;
    std::size_t max_bytes_ = 0;
    GlSampler nearest_;
    std::map<frame::PixelFormat, GlProgram> programs_;
};

}  // namespace camrig::render::gl
