#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/camera/pose.h"
#include "core/render/renderer.h"

namespace camrig::render {

/// All that a camera's picture of what does not move follows from: equal keys, equal bytes.
struct StaticLayerKey {
    std::uint64_t spec_revision = 0;  ///< size, optics, lens, antialiasing, near, far
    camera::Pose pose;
    world::Quality quality = world::Quality::simple;
    std::uint64_t statics = 0;  ///< what it sees of objects, lights and environment, as the renderer counts that
    friend bool operator==(const StaticLayerKey&, const StaticLayerKey&) = default;
};

/// Which cameras have a static layer, and how much memory all of them take. What a layer is, the owner says.
///
/// A camera gets one when it is seen a second time with the same key: one that moves pays nothing. Memory is bounded; a
/// layer that was not used for a while makes room, one in use never does, so that too many cameras do not push each
/// other out in turn.
template <typename Layer>
class LayerTable {
public:
    explicit LayerTable(std::int64_t max_bytes) : max_bytes_(max_bytes) {}

    void next_instant() { ++instant_; }

    /// Null while the camera moves, and always when max_bytes is 0. Good until the next call.
    Layer* layer_of(CameraId camera, const StaticLayerKey& key) {
        if (max_bytes_ == 0) return nullptr;
        const auto [at, is_new] = entries_.try_emplace(camera);
        Entry& entry = at->second;
        entry.used_at = instant_;
        if (is_new || entry.key != key) {
            stale_ += entry.bytes > 0;
            drop(entry);
            entry.key = key;
            entry.refused_at.reset();
            return nullptr;
        }
        if (entry.refused_at && *entry.refused_at + kept_instants > instant_) return nullptr;
        return &entry.layer;
    }

    /// Frees layers that were not used for a while until there is room for so much more; false if there is not.
    bool make_room(std::int64_t bytes) {
        while (bytes_ + bytes > max_bytes_) {
            Entry* oldest = nullptr;
            for (auto& [camera, entry] : entries_) {
                const bool may_go = entry.bytes > 0 && entry.used_at + kept_instants < instant_;
                if (may_go && (oldest == nullptr || entry.used_at < oldest->used_at)) oldest = &entry;
            }
            if (oldest == nullptr) return false;
            drop(*oldest);
            ++evicted_;
        }
        return true;
    }

    /// Says that the layer takes so much more memory, or less.
    void charge(Layer& layer, std::int64_t bytes) {
        for (auto& [camera, entry] : entries_) {
            if (&entry.layer == &layer) entry.bytes += bytes;
        }
        bytes_ += bytes;
    }
    /// Frees what is kept of it: there was no room. The camera gets none for a while.
    void refuse(Layer& layer) {
        for (auto& [camera, entry] : entries_) {
            if (&entry.layer != &layer) continue;
            drop(entry);
            entry.refused_at = instant_;
        }
    }
    void count_kept() { ++kept_; }
    void count_reused() { ++reused_; }

    /// A layer, its key and its memory.
    struct Kept {
        StaticLayerKey key;
        Layer layer;
        std::int64_t bytes = 0;
    };
    /// Gives away what is kept of a camera.
    std::optional<Kept> take(CameraId camera) {
        const auto found = entries_.find(camera);
        if (found == entries_.end() || found->second.bytes == 0) return std::nullopt;
        Entry& entry = found->second;
        std::optional<Kept> kept = Kept{entry.key, std::move(entry.layer), entry.bytes};
        drop(entry);
        entries_.erase(found);
        return kept;
    }
    /// Takes over what was kept of a camera that it does not know, if there is room.
    void put(CameraId camera, Kept kept) {
        if (!make_room(kept.bytes)) return;
        entries_.emplace(camera, Entry{kept.key, std::move(kept.layer), kept.bytes, instant_, std::nullopt});
        bytes_ += kept.bytes;
    }
    bool knows(CameraId camera) const { return entries_.contains(camera); }

    void forget(CameraId camera) {
        const auto found = entries_.find(camera);
        if (found == entries_.end()) return;
        drop(found->second);
        entries_.erase(found);
    }

    void clear() {
        entries_.clear();
        bytes_ = 0;
    }

    RenderCounters counters() const {
        RenderCounters counters{.layer_bytes = bytes_,
                                .layers_drawn = kept_,
                                .layers_reused = reused_,
                                .layers_stale = stale_,
                                .layers_evicted = evicted_};
        for (const auto& [camera, entry] : entries_) counters.layers += entry.bytes > 0;
        return counters;
    }

    /// A layer that was not used for so many instants may be freed for another.
    static constexpr std::uint64_t kept_instants = 64;

private:
    struct Entry {
        StaticLayerKey key;
        Layer layer;
        std::int64_t bytes = 0;
        std::uint64_t used_at = 0;
        std::optional<std::uint64_t> refused_at;
    };

    void drop(Entry& entry) {
        bytes_ -= entry.bytes;
        entry.bytes = 0;
        entry.layer = {};
    }

    std::int64_t max_bytes_;
    std::int64_t bytes_ = 0;
    std::uint64_t instant_ = 0;
    std::uint64_t kept_ = 0, reused_ = 0, stale_ = 0, evicted_ = 0;
    std::map<CameraId, Entry> entries_;
};

}  // namespace camrig::render
