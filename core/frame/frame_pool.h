#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "core/frame/frame.h"

namespace camrig::frame {

/// Recycles frame buffers, so that steady state allocates nothing. Any thread.
///
/// Keeps at most `max_idle_bytes` of unused buffers (the oldest go first); buffers in use are bounded by their users'
/// mailboxes and queues. Frames may outlive the pool.
class FramePool {
public:
    explicit FramePool(std::size_t max_idle_bytes = std::size_t{256} << 20);
    ~FramePool();
    FramePool(const FramePool&) = delete;
    FramePool& operator=(const FramePool&) = delete;

    /// A frame with room for info.format and info.size; the content is undefined, or what Frame::held_before() says.
    /// Memory of a frame with a content mark is given to the same camera and kind first. Fill it, then hand it on as a
    /// FrameRef.
    std::shared_ptr<Frame> acquire(FrameInfo info);

    std::size_t idle_bytes() const;
    /// Frees what nobody uses now: a camera is gone, and perhaps nobody will want its size of buffers again.
    void release_idle();

private:
    struct Shelf;
    std::shared_ptr<Shelf> shelf_;
};

}  // namespace camrig::frame
