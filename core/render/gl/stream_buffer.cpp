#include "core/render/gl/stream_buffer.h"

#include <algorithm>
#include <new>

namespace camrig::render::gl {
namespace {

constexpr std::size_t first_chunk_bytes = std::size_t{1} << 20;

}  // namespace

StreamBuffer::StreamBuffer(const GlFunctions& gl) : gl_(gl) {
    GLint uniform = 256, storage = 256;
    gl.GetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &uniform);
    gl.GetIntegerv(GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT, &storage);
    // Powers of two.
    alignment_ = static_cast<std::size_t>(std::max({uniform, storage, 16}));
}

void StreamBuffer::add_chunk(std::size_t size) {
    constexpr GLbitfield access = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    Chunk chunk{.buffer = make_buffer(gl_), .size = size};
    gl_.NamedBufferStorage(chunk.buffer.name(), static_cast<GLsizeiptr>(size), nullptr, access);
    chunk.data =
        static_cast<std::byte*>(gl_.MapNamedBufferRange(chunk.buffer.name(), 0, static_cast<GLsizeiptr>(size), access));
    if (chunk.data == nullptr) throw std::bad_alloc();
    if (!chunks_.empty()) full_ += chunks_.back().size;
    chunks_.push_back(std::move(chunk));
    used_ = 0;
}

StreamBuffer::Piece StreamBuffer::allocate(std::size_t bytes, std::size_t readable) {
    const std::size_t offset = (used_ + alignment_ - 1) / alignment_ * alignment_;
    if (chunks_.empty() || offset + std::max(bytes, readable) > chunks_.back().size) {
        // Doubling: after a few instants everything fits into one chunk and nothing is allocated any more.
        add_chunk(std::max(
            {first_chunk_bytes, chunks_.empty() ? 0 : 2 * chunks_.back().size, 2 * std::max(bytes, readable)}));
        return allocate(bytes, readable);
    }
    used_ = offset + bytes;
    const Chunk& chunk = chunks_.back();
    return {chunk.buffer.name(), static_cast<GLintptr>(offset), chunk.data + offset};
}

void StreamBuffer::reset() {
    if (chunks_.size() > 1) chunks_.erase(chunks_.begin(), chunks_.end() - 1);
    used_ = full_ = 0;
}

}  // namespace camrig::render::gl
