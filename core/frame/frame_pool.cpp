#include "core/frame/frame_pool.h"

#include <algorithm>
#include <deque>
#include <new>
#include <utility>

namespace camrig::frame {

/// Idle frames, oldest first. Kept alive by the pool and by every frame that will come back to it.
struct FramePool::Shelf {
    std::mutex mutex;
    std::deque<std::unique_ptr<Frame>> idle;
    std::size_t idle_bytes = 0;
    std::size_t max_idle_bytes = 0;
    bool open = true;  ///< false once the pool is gone: returning frames are freed

    /// The newest idle frame whose buffer has exactly this size (its memory is the warmest); null if there is none.
    /// Cameras come in few sizes and formats, so an exact match is the rule, and it needs no clearing of new bytes.
    /// What a maker has marked goes back to the same camera and kind, and to others only when nothing else is left.
    std::unique_ptr<Frame> take(std::size_t bytes, const FrameInfo& info) {
        enum Rank { unfit, of_others, unmarked, own };
        const auto rank_of = [&](const Frame& frame) {
            if (frame.bytes().size() != bytes) return unfit;
            if (frame.content_mark() == 0) return unmarked;
            const FrameInfo& held = frame.info();
            return held.camera_id == info.camera_id && held.kind == info.kind && held.format == info.format ? own
                                                                                                            : of_others;
        };
        std::lock_guard lock(mutex);
        auto found = idle.rend();
        Rank best = unfit;
        for (auto at = idle.rbegin(); at != idle.rend() && best != own; ++at) {
            const Rank rank = rank_of(**at);
            if (rank <= best) continue;
            best = rank;
            found = at;
        }
        if (found == idle.rend()) return nullptr;
        std::unique_ptr<Frame> frame = std::move(*found);
        idle.erase(std::next(found).base());
        idle_bytes -= bytes;
        return frame;
    }

    void put(std::unique_ptr<Frame> frame) {
        // Freed outside the lock: unmapping megabytes takes its time. No deque: an empty one has memory already.
        std::vector<std::unique_ptr<Frame>> evicted;
        std::lock_guard lock(mutex);
        const std::size_t bytes = frame->bytes().size();
        if (!open || bytes > max_idle_bytes) {
            evicted.push_back(std::move(frame));
            return;
        }
        while (idle_bytes + bytes > max_idle_bytes || idle.size() >= max_idle_frames) {
            const std::size_t freed = idle.front()->bytes().size();
            evicted.push_back(std::move(idle.front()));
            idle.pop_front();
            idle_bytes -= freed;
        }
        idle.push_back(std::move(frame));
        idle_bytes += bytes;
    }

    static constexpr std::size_t max_idle_frames = 1024;  ///< bounds the search when pictures are tiny
};

FramePool::FramePool(std::size_t max_idle_bytes) : shelf_(std::make_shared<Shelf>()) {
    shelf_->max_idle_bytes = max_idle_bytes;
}

FramePool::~FramePool() {
    {
        std::lock_guard lock(shelf_->mutex);
        shelf_->open = false;
    }
    release_idle();
}

std::shared_ptr<Frame> FramePool::acquire(FrameInfo info) {
    const std::size_t bytes = bytes_of(info.format, info.size);
    std::unique_ptr<Frame> frame = shelf_->take(bytes, info);
    if (frame) {
        const std::uint64_t held = frame->content_mark();
        *frame = Frame(std::move(info), std::move(*frame).take_bytes(), held);
    } else {
        frame = std::make_unique<Frame>(std::move(info), std::vector<std::byte>(bytes));
    }
    return {frame.release(), [shelf = shelf_](Frame* used) {
                try {
                    shelf->put(std::unique_ptr<Frame>(used));
                } catch (const std::bad_alloc&) {  // no room in the lists: it is freed
                }
            }};
}

void FramePool::release_idle() {
    std::deque<std::unique_ptr<Frame>> freed;
    std::lock_guard lock(shelf_->mutex);
    freed.swap(shelf_->idle);
    shelf_->idle_bytes = 0;
}

std::size_t FramePool::idle_bytes() const {
    std::lock_guard lock(shelf_->mutex);
    return shelf_->idle_bytes;
}

}  // namespace camrig::frame
