#include "core/render/gl/static_layers.h"

#include <algorithm>

namespace camrig {
namespace {

std::int64_t bytes_of(const ColorTarget& target) {
    return target.size.pixels() * target.samples * (target.depth ? 4 + 4 : 4);
}

std::int64_t bytes_of(const TruthTarget& target) {
    return target.size.pixels() * (4 + 16 + 4);
}

/// Texel by texel, sample by sample, whatever the format: no state takes part, no value is converted. On llvmpipe a
/// copy of memory: a picture costs 1 to 2 ms less CPU than with glBlitNamedFramebuffer, which draws (640x480; 1080p:
/// 10).
void copy(const GlFunctions& gl, const GlTexture& from, const GlTexture& to, const PixelRect& rect, int samples = 1) {
    const GLenum target = samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
    gl.CopyImageSubData(from.name(), target, 0, rect.x0, rect.y0, 0, to.name(), target, 0, rect.x0, rect.y0, 0,
                        rect.width(), rect.height(), 1);
}

PixelRect all_of(ImageSize size) {
    return {0, 0, size.width, size.height};
}

void copy(const GlFunctions& gl, const ColorTarget& from, const ColorTarget& to) {
    copy(gl, from.color, to.color, all_of(from.size), from.samples);
    if (from.depth && to.depth) copy(gl, from.depth, to.depth, all_of(from.size), from.samples);
}

void copy(const GlFunctions& gl, const TruthTarget& from, const TruthTarget& to) {
    copy(gl, from.instance, to.instance, all_of(from.size));
    copy(gl, from.normal, to.normal, all_of(from.size));
    copy(gl, from.depth, to.depth, all_of(from.size));
}

}  // namespace

StaticLayers::Layer* StaticLayers::layer_of(CameraId camera, const StaticLayerKey& key) {
    if (max_bytes_ == 0) return nullptr;
    const auto [at, is_new] = entries_.try_emplace(camera);
    Entry& entry = at->second;
    entry.used_at = instant_;
    if (is_new || entry.key != key) {
        stale_ += entry.bytes > 0;
        drop(entry);
        entry.key = key;
        return nullptr;
    }
    return &entry.layer;
}

void StaticLayers::drop(Entry& entry) {
    bytes_ -= entry.bytes;
    entry.bytes = 0;
    entry.layer = {};
}

bool StaticLayers::make_room(std::int64_t bytes) {
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

StaticLayers::Entry& StaticLayers::entry_of(Layer& layer) {
    const auto found = std::ranges::find_if(entries_, [&](auto& each) { return &each.second.layer == &layer; });
    CHECK(found != entries_.end());
    return found->second;
}

template <typename T>
void StaticLayers::add(Layer& layer, std::optional<T>& place, Result<T> made, const T& drawn) {
    if (!made) return;  // no memory on the device: drawn in full, as if there were no layers
    copy(gl_, drawn, *made);
    const std::int64_t bytes = bytes_of(*made);
    place = std::move(*made);
    entry_of(layer).bytes += bytes;
    bytes_ += bytes;
}

void StaticLayers::keep(Layer& layer, const ColorTarget& drawn) {
    if (!make_room(bytes_of(drawn))) return;
    add(layer, layer.color, make_color_target(gl_, drawn.size, {.samples = drawn.samples}), drawn);
    layer.number = ++numbers_;
    ++kept_;
}

void StaticLayers::keep_finished(Layer& layer, const ColorTarget& drawn) {
    if (make_room(bytes_of(drawn) / 2))
        add(layer, layer.finished, make_color_target(gl_, drawn.size, {.samples = drawn.samples, .has_depth = false}),
            drawn);
    copy(gl_, *layer.color, drawn);
    if (layer.finished) return;
    const std::int64_t bytes = bytes_of(*layer.color);
    entry_of(layer).bytes -= bytes;
    bytes_ -= bytes;
    layer.color.reset();
}

void StaticLayers::keep(Layer& layer, const TruthTarget& drawn) {
    if (!make_room(bytes_of(drawn))) return;
    add(layer, layer.truth, make_truth_target(gl_, drawn.size), drawn);
    ++kept_;
}

void StaticLayers::restore(const ColorTarget& kept, const ColorTarget& to) {
    copy(gl_, kept, to);
    ++reused_;
}

void StaticLayers::restore(const TruthTarget& kept, const TruthTarget& to) {
    copy(gl_, kept, to);
    ++reused_;
}

void StaticLayers::restore_around(const Layer& layer, const ColorTarget& to, std::span<const PixelRect> changed,
                                  std::span<const PixelRect> rects, bool all_depth) {
    const ColorTarget& opaque = *layer.color;
    const ColorTarget& finished = layer.finished ? *layer.finished : opaque;
    for (const PixelRect& rect : changed) copy(gl_, finished.color, to.color, rect, to.samples);
    if (all_depth) copy(gl_, opaque.depth, to.depth, all_of(to.size), to.samples);
    for (const PixelRect& rect : rects) {
        if (layer.finished) copy(gl_, opaque.color, to.color, rect, to.samples);
        if (!all_depth) copy(gl_, opaque.depth, to.depth, rect, to.samples);
    }
    ++reused_;
}

void StaticLayers::forget(CameraId camera) {
    const auto found = entries_.find(camera);
    if (found == entries_.end()) return;
    drop(found->second);
    entries_.erase(found);
}

RenderCounters StaticLayers::counters() const {
    RenderCounters counters{.layer_bytes = bytes_,
                            .layers_drawn = kept_,
                            .layers_reused = reused_,
                            .layers_stale = stale_,
                            .layers_evicted = evicted_};
    for (const auto& [camera, entry] : entries_) counters.layers += entry.bytes > 0;
    return counters;
}

}  // namespace camrig
