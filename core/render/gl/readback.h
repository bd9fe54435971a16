#pragma once

#include <cstddef>
#include <span>

#include "core/frame/frame.h"
#include "core/render/gl/gl_objects.h"
#include "core/render/gl/view_target.h"

namespace camrig::render::gl {

/// How pixels come to host memory.
/// `direct`: glReadPixels into the frame. On a CPU rasteriser this is one memcpy; a pixel buffer would only add
/// another. `buffered`: glReadPixels into a mapped pixel buffer behind the draws, a fence, and one memcpy: the
/// only way that does not stop a GPU once per camera.
enum class ReadbackMode { direct, buffered };

/// Starts reading one kind of picture from the framebuffer that holds it; `to` is host memory, or an offset into the
/// bound GL_PIXEL_PACK_BUFFER.
struct PictureSource {
    GLuint framebuffer = 0;
    bool depth_is_color = false;
    GLuint codes = 0;  ///< ColorTarget::codes
};
void read_pixels(const GlFunctions& gl, PictureSource source, frame::FrameKind kind, ImageSize size, void* to);

/// Host-visible memory that the pictures of one instant go to (ReadbackMode::buffered).
class ReadbackBuffer {
public:
    explicit ReadbackBuffer(const GlFunctions& gl) : gl_(gl) {}
    /// Of the buffer, for a picture of so many bytes: shader storage begins at multiples of 256.
    static std::size_t room_for(std::size_t bytes) { return (bytes + 255) / 256 * 256; }
    /// Makes room for an instant; the device must be done with the one before. Throws std::bad_alloc when the device
    /// has no memory left (GlRenderer::draw catches it).
    void reset(std::size_t room);
    /// Where the next picture goes.
    std::size_t allocate(std::size_t bytes);
    void read(PictureSource source, frame::FrameKind kind, ImageSize size, std::size_t offset);
    GLuint name() const { return buffer_.name(); }
    /// After all that goes to the buffer: blocks until it has arrived. Error: the device gave no sign of life for 10 s.
    Result<void> wait();
    std::span<const std::byte> bytes(std::size_t offset, std::size_t size) const { return {data_ + offset, size}; }

private:
    const GlFunctions& gl_;
    GlBuffer buffer_;
    std::byte* data_ = nullptr;
    std::size_t capacity_ = 0;
    std::size_t used_ = 0;
};

}  // namespace camrig::render::gl
