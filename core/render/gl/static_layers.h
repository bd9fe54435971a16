#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>

#include "core/base/ids.h"
#include "core/camera/pose.h"
#include "core/render/gl/view_target.h"
#include "core/render/pixel_rect.h"
#include "core/render/renderer.h"

namespace camrig {

/// All that a camera's picture of what does not move follows from: equal keys, equal bytes.
struct StaticLayerKey {
    std::uint64_t spec_revision = 0;  ///< size, optics, lens, antialiasing, near, far
    Pose pose;
    Quality quality = Quality::simple;
    std::uint64_t statics = 0;  ///< which static set, as the renderer counts them: objects, lights, environment
    friend bool operator==(const StaticLayerKey&, const StaticLayerKey&) = default;
};

/// Static layers. Surveillance cameras stand still and most of what they see never moves, so colour and depth (ids and
/// normals, where asked for) of the static opaque geometry are drawn once per key, and copied each instant; movers are
/// drawn over them, blended surfaces last. Bit-identical to a full draw, because the full draw has the same order
/// (StaticLayer tests), which is why it is always on.
///
/// Where movers are few, even less is done: the picture as it is without them, blended surfaces and all, is kept too,
/// and only in the rectangles that movers may touch is it built up again from the opaque layer.
///
/// Layers are of the source picture, before samples are resolved and the lens is looked through. A camera gets one when
/// it is seen a second time with the same key: one that moves pays nothing. Memory is bounded; a layer that was not
/// used for a while makes room, one in use never does, so that too many cameras do not push each other out in turn.
class StaticLayers {
public:
    /// Of one camera. What is not kept yet is empty.
    struct Layer {
        std::optional<ColorTarget> color;
        /// With the blended static surfaces, without depth; empty also if there are none: then it is `color`.
        std::optional<ColorTarget> finished;
        std::optional<TruthTarget> truth;
        std::uint64_t number = 0;  ///< of these colours: no two layers that were ever kept have the same
    };
    StaticLayers(const GlFunctions& gl, std::int64_t max_bytes) : gl_(gl), max_bytes_(max_bytes) {}

    void next_instant() { ++instant_; }
    /// Null while the camera moves, and always when max_bytes is 0. Good until the next call.
    Layer* layer_of(CameraId camera, const StaticLayerKey& key);
    /// Copies the static part of a picture into the layer, if there is room.
    void keep(Layer& layer, const ColorTarget& drawn);
    /// `drawn` is the source of `layer.color` with what is blended on top; it becomes that source again. If there is no
    /// room for it, the layer has no colours at all: the opaque ones alone would pass for the finished picture.
    void keep_finished(Layer& layer, const ColorTarget& drawn);
    void keep(Layer& layer, const TruthTarget& drawn);
    /// Copies a kept picture back to where movers are drawn over it.
    void restore(const ColorTarget& kept, const ColorTarget& to);
    void restore(const TruthTarget& kept, const TruthTarget& to);
    /// In `changed`, all of `to` that does not show it yet, the finished picture; then in `rects` what is opaque and
    /// its depth, for more to be drawn there. Depth elsewhere is left as it is unless `all_depth`.
    void restore_around(const Layer& layer, const ColorTarget& to, std::span<const PixelRect> changed,
                        std::span<const PixelRect> rects, bool all_depth);
    void forget(CameraId camera);

    RenderCounters counters() const;

    /// A layer that was not used for so many instants may be freed for another.
    static constexpr std::uint64_t kept_instants = 64;

private:
    struct Entry {
        StaticLayerKey key;
        Layer layer;
        std::int64_t bytes = 0;
        std::uint64_t used_at = 0;
    };
    template <typename T>
    void add(Layer& layer, std::optional<T>& place, Result<T> made, const T& drawn);
    void drop(Entry& entry);
    bool make_room(std::int64_t bytes);
    Entry& entry_of(Layer& layer);

    const GlFunctions& gl_;
    std::int64_t max_bytes_;
    std::int64_t bytes_ = 0;
    std::uint64_t instant_ = 0;
    std::uint64_t numbers_ = 0;
    std::uint64_t kept_ = 0, reused_ = 0, stale_ = 0, evicted_ = 0;
    std::map<CameraId, Entry> entries_;
};

}  // namespace camrig
