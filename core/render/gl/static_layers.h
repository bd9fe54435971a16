#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/render/gl/view_target.h"
#include "core/render/layer_table.h"
#include "core/render/pixel_rect.h"

namespace camrig::render::gl {

/// Static layers. Surveillance cameras stand still and most of what they see never moves, so colour and depth (ids and
/// normals, where asked for) of the static opaque geometry are drawn once per key, and copied each instant; movers are
/// drawn over them, blended surfaces last. Bit-identical to a full draw, because the full draw has the same order
/// (StaticLayer tests), which is why it is always on.
///
/// Where movers are few, even less is done: the picture as it is without them, blended surfaces and all, is kept too,
/// and only in the rectangles that movers may touch is it built up again from the opaque layer.
///
/// Layers are of the source picture, before samples are resolved and the lens is looked through.
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
    StaticLayers(const GlFunctions& gl, std::int64_t max_bytes) : gl_(gl), table_(max_bytes) {}

    void next_instant() { table_.next_instant(); }
    /// Null while the camera moves, and always when max_bytes is 0. Good until the next call.
    Layer* layer_of(CameraId camera, const StaticLayerKey& key) { return table_.layer_of(camera, key); }
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
    void forget(CameraId camera) { table_.forget(camera); }

    RenderCounters counters() const { return table_.counters(); }

private:
    template <typename T>
    void add(Layer& layer, std::optional<T>& place, Result<T> made, const T& drawn);

    const GlFunctions& gl_;
    LayerTable<Layer> table_;
    std::uint64_t numbers_ = 0;
};

}  // namespace camrig::render::gl
