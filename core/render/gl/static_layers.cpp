#include "core/render/gl/static_layers.h"

namespace camrig::render::gl {
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

template <typename T>
void StaticLayers::add(Layer& layer, std::optional<T>& place, Result<T> made, const T& drawn) {
    if (!made) return;  // no memory on the device: drawn in full, as if there were no layers
    copy(gl_, drawn, *made);
    const std::int64_t bytes = bytes_of(*made);
    place = std::move(*made);
    table_.charge(layer, bytes);
}

void StaticLayers::keep(Layer& layer, const ColorTarget& drawn) {
    if (!table_.make_room(bytes_of(drawn))) return;
    add(layer, layer.color, make_color_target(gl_, drawn.size, {.samples = drawn.samples}), drawn);
    layer.number = ++numbers_;
    table_.count_kept();
}

void StaticLayers::keep_finished(Layer& layer, const ColorTarget& drawn) {
    if (table_.make_room(bytes_of(drawn) / 2))
        add(layer, layer.finished, make_color_target(gl_, drawn.size, {.samples = drawn.samples, .has_depth = false}),
            drawn);
    copy(gl_, *layer.color, drawn);
    if (layer.finished) return;
    table_.charge(layer, -bytes_of(*layer.color));
    layer.color.reset();
}

void StaticLayers::keep(Layer& layer, const TruthTarget& drawn) {
    if (!table_.make_room(bytes_of(drawn))) return;
    add(layer, layer.truth, make_truth_target(gl_, drawn.size), drawn);
    table_.count_kept();
}

void StaticLayers::restore(const ColorTarget& kept, const ColorTarget& to) {
    copy(gl_, kept, to);
    table_.count_reused();
}

void StaticLayers::restore(const TruthTarget& kept, const TruthTarget& to) {
    copy(gl_, kept, to);
    table_.count_reused();
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
    table_.count_reused();
}

}  // namespace camrig::render::gl
