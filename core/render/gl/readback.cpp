#include "core/render/gl/readback.h"

#include <new>

#include "core/base/time.h"

namespace camrig::render::gl {
namespace {

constexpr TimeNs device_timeout_ns = 10 * ns_per_s;

}  // namespace

void read_pixels(const GlFunctions& gl, PictureSource source, frame::FrameKind kind, ImageSize size, void* to) {
    struct Format {
        GLenum format;
        GLenum type;
        GLenum attachment;
    };
    Format format{GL_RGBA, GL_UNSIGNED_BYTE, GL_COLOR_ATTACHMENT0};
    if (kind == frame::FrameKind::depth) {
        format = source.depth_is_color ? Format{GL_RED, GL_FLOAT, GL_COLOR_ATTACHMENT2}
                                       : Format{GL_DEPTH_COMPONENT, GL_FLOAT, GL_COLOR_ATTACHMENT0};
    }
    if (kind == frame::FrameKind::instance || kind == frame::FrameKind::semantic)
        format = {GL_RED_INTEGER, GL_UNSIGNED_INT, GL_COLOR_ATTACHMENT0};
    if (kind == frame::FrameKind::normal) format = {GL_RGB, GL_FLOAT, GL_COLOR_ATTACHMENT1};
    gl.NamedFramebufferReadBuffer(source.framebuffer, format.attachment);
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, source.framebuffer);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.ReadPixels(0, 0, size.width, size.height, format.format, format.type, to);
}

void ReadbackBuffer::reset(std::size_t room) {
    used_ = 0;
    if (room <= capacity_) return;
    // Client storage keeps the mapping in cached host memory: uncached reads are 20 times slower.
    constexpr GLbitfield access = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    capacity_ = 0;
    buffer_ = make_buffer(gl_);
    gl_.NamedBufferStorage(buffer_.name(), static_cast<GLsizeiptr>(room), nullptr, access | GL_CLIENT_STORAGE_BIT);
    data_ = static_cast<std::byte*>(gl_.MapNamedBufferRange(buffer_.name(), 0, static_cast<GLsizeiptr>(room), access));
    if (data_ == nullptr) throw std::bad_alloc();
    capacity_ = room;
}

std::size_t ReadbackBuffer::allocate(std::size_t bytes) {
    const std::size_t offset = used_;
    used_ += room_for(bytes);
    CHECK(used_ <= capacity_);
    return offset;
}

void ReadbackBuffer::read(PictureSource source, frame::FrameKind kind, ImageSize size, std::size_t offset) {
    gl_.BindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.name());
    read_pixels(gl_, source, kind, size, reinterpret_cast<void*>(offset));
    gl_.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
}

Result<void> ReadbackBuffer::wait() {
    gl_.MemoryBarrier(GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT);  // for what shaders wrote
    const GLsync fence = gl_.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    const GLenum state = gl_.ClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, device_timeout_ns);
    gl_.DeleteSync(fence);
    if (state == GL_ALREADY_SIGNALED || state == GL_CONDITION_SATISFIED) return {};
    return error(ErrorKind::unavailable, "the graphics device did not finish drawing within 10 s");
}

}  // namespace camrig::render::gl
