#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "core/render/layer_table.h"
#include "core/render/software/view_work.h"

namespace camrig::render::software {

/// Static layers on their way from one drawer to another, which draws the camera from now on: without them it would
/// draw two pictures in full first. Any thread.
class HandedLayers {
public:
    struct Handed {
        LayerTable<StaticLayer>::Kept kept;
        std::weak_ptr<const world::StaticSet> statics;  ///< what it shows
    };

    /// What waits takes at most max_bytes: what is beyond is not kept. `giver` does not take it back.
    void put(CameraId camera, const void* giver, Handed handed, std::int64_t max_bytes) {
        const std::lock_guard lock(mutex_);
        remove(waiting_.find(camera));
        if (bytes_ + handed.kept.bytes > max_bytes) return;
        bytes_ += handed.kept.bytes;
        waiting_.emplace(camera, std::pair(giver, std::move(handed)));
    }
    std::optional<Handed> take(CameraId camera, const void* taker) {
        const std::lock_guard lock(mutex_);
        const auto found = waiting_.find(camera);
        if (found == waiting_.end() || found->second.first == taker) return std::nullopt;
        std::optional<Handed> handed = std::move(found->second.second);
        remove(found);
        return handed;
    }
    void forget(CameraId camera) { std::ignore = take(camera, nullptr); }

private:
    using Waiting = std::map<CameraId, std::pair<const void*, Handed>>;
    void remove(Waiting::iterator one) {
        if (one == waiting_.end()) return;
        bytes_ -= one->second.second.kept.bytes;
        waiting_.erase(one);
    }

    std::mutex mutex_;
    Waiting waiting_;
    std::int64_t bytes_ = 0;
};

}  // namespace camrig::render::software
