#pragma once

#include <cstddef>
#include <vector>

#include "core/render/gl/gl_objects.h"

namespace camrig::render::gl {

/// Memory for one instant that the CPU writes once and the device reads: blocks of shaders and skinned vertices. Mapped
/// for good, so writing is a plain store: no driver call, no check whether the device is still busy. The owner calls
/// reset() only when the device is done with everything given out before.
class StreamBuffer {
public:
    explicit StreamBuffer(const GlFunctions& gl);

    struct Piece {
        GLuint buffer = 0;
        GLintptr offset = 0;
        std::byte* data = nullptr;
    };
    /// Aligned for uniform and storage blocks. From its beginning on at least `readable` bytes may be bound; behind the
    /// piece they are anybody's. Throws std::bad_alloc when the device has no memory left (GlRenderer::draw catches
    /// it).
    Piece allocate(std::size_t bytes, std::size_t readable = 0);
    void reset();
    /// Bytes since the last reset().
    std::size_t used() const { return full_ + used_; }
    std::size_t capacity() const { return full_ + (chunks_.empty() ? 0 : chunks_.back().size); }

private:
    struct Chunk {
        GlBuffer buffer;
        std::byte* data = nullptr;
        std::size_t size = 0;
    };
    void add_chunk(std::size_t size);

    const GlFunctions& gl_;
    std::size_t alignment_ = 256;
    std::vector<Chunk> chunks_;  ///< the last one is being filled
    std::size_t used_ = 0;       ///< of that one
    std::size_t full_ = 0;       ///< those before it
};

}  // namespace camrig::render::gl
