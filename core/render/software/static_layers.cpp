#include "core/render/software/static_layers.h"

#include <atomic>
#include <utility>

#include "core/render/software/channels.h"

namespace camrig::render::software {

std::uint64_t next_content_number() {
    static std::atomic<std::uint64_t> last = 0;
    return ++last;
}

StaticLayer* StaticLayers::layer_of(const View& view, const scene::SceneView& scene) {
    const StaticLayerKey key{view.spec_revision, view.pose, view.quality, seen_.number_of(view, scene)};
    if (!table_.knows(view.camera)) take_handed(view, scene, key);
    return table_.layer_of(view.camera, key);
}

void StaticLayers::take_handed(const View& view, const scene::SceneView& scene, const StaticLayerKey& key) {
    auto handed = handed_->take(view.camera, this);
    if (!handed || handed->statics.lock() != scene.scene->snapshot()->statics) return;
    // Each drawer counts what it sees.
    handed->kept.key.statics = key.statics;
    if (handed->kept.key == key) table_.put(view.camera, std::move(handed->kept));
}

void StaticLayers::make(ViewWork& work, bool has_blended, bool has_catchers) {
    const ImageSize size = work.view->spec->size;
    StaticLayer& layer = *work.layer;
    const bool is_shaded = work.is_shaded() && !layer.picture, is_new = layer.number == 0;
    const bool is_blended = is_shaded && has_blended && !work.has_film(), has_steps = is_shaded && work.has_areas;
    const bool is_shadowed = is_shaded && work.movers_darken();
    const auto is_missing = [&](frame::FrameKind kind) {
        const auto k = index_of(kind);
        return work.channels[k].frame != nullptr && !layer.channels[k];
    };
    const auto is_light = static_cast<bool>(work.canvas.light);
    std::int64_t bytes =
        (is_new + has_steps + is_shadowed + (is_shadowed && has_catchers)) * Plane<float>::bytes_for(size) +
        (is_shaded + is_blended) * KeptPicture::bytes_for(size, is_light);
    for (const frame::FrameKind kind : channel_kinds)
        if (is_missing(kind)) bytes += Plane<float>::bytes_for(words_of(kind, size));
    {
        const std::lock_guard lock(mutex_);
        if (!table_.make_room(bytes)) {
            work.layer = nullptr;
            return;
        }
        table_.charge(layer, bytes);
        if (is_new) {
            table_.count_kept();
            layer.number = next_content_number();
        }
    }
    if (is_new) layer.depth = Plane<float>(size);
    if (is_shaded) layer.picture = KeptPicture(size, is_light);
    if (is_shaded) layer.is_blended = has_blended;
    if (is_blended) layer.finished = KeptPicture(size, is_light);
    if (is_shadowed) {
        layer.shadowed = std::make_unique<ShadowedStatics>();
        layer.shadowed->numbers = TriangleNumbers(size);
        if (has_catchers) layer.shadowed->depth = Plane<float>(size);
    }
    if (has_steps) layer.areas.steps = Plane<std::uint32_t>(size);
    for (const frame::FrameKind kind : channel_kinds)
        if (is_missing(kind)) layer.channels[index_of(kind)] = Plane<std::uint32_t>(words_of(kind, size));
}

void StaticLayers::keep_areas(ViewWork& work, const ViewScratch& scratch) {
    // Where other kinds were missing they are made anew, as they were.
    StaticPixels& pixels = work.layer->areas.pixels;
    const std::int64_t before = pixels.bytes();
    scratch.areas.gather(pixels);
    charge_for(work, pixels.bytes() - before);
}

void StaticLayers::keep_shadowed(ViewWork& work, ViewScratch& scratch) {
    ShadowedStatics& shadowed = *work.layer->shadowed;
    const std::int64_t before = shadowed.bytes();
    shadowed.geometry = std::exchange(scratch.geometry, {});
    shadowed.proxies = scratch.proxies;
    charge_for(work, shadowed.bytes() - before);
}

void StaticLayers::keep_sites(ViewWork& work) {
    if (!work.takes_picture() || work.has_sites || work.layer == nullptr || !work.layer->picture) return;
    const sensor::SensorSpec& spec = work.exposure->sensor->spec();
    sensor::SiteLight& sites = work.layer->sites;
    const std::int64_t bytes = sensor::SiteLight::bytes_for(spec, work.view->spec->size) - sites.bytes();
    const std::lock_guard lock(mutex_);
    if (!table_.make_room(bytes)) return;
    table_.charge(*work.layer, bytes);
    sites.fit(spec, work.view->spec->size);
    work.keeps_sites = true;
}

void StaticLayers::charge_for(ViewWork& work, std::int64_t bytes) {
    const std::lock_guard lock(mutex_);
    // In use it is never freed for another: a picture's edges are a part of its memory that is known only now.
    if (table_.make_room(bytes)) {
        table_.charge(*work.layer, bytes);
    } else {
        table_.refuse(*work.layer);
        work.layer = nullptr;
    }
}

void StaticLayers::keep_what_was_drawn(ViewWork& work, ViewScratch& scratch) {
    if (work.layer == nullptr || work.is_in_parts) return;
    if (work.has_areas) keep_areas(work, scratch);
    if (work.layer != nullptr && work.is_shaded() && work.layer->shadowed != nullptr) keep_shadowed(work, scratch);
}

bool StaticLayers::keep_silhouette(StaticLayer& layer, ObjectId object, const frame::Silhouette& runs) {
    const auto bytes = static_cast<std::int64_t>(runs.size() * sizeof(frame::PixelRun));
    if (!table_.make_room(bytes)) return false;
    table_.charge(layer, bytes);
    layer.silhouettes.emplace(object, runs);
    return true;
}

void StaticLayers::forget(CameraId camera) {
    handed_->forget(camera);
    seen_.forget(camera);
    table_.forget(camera);
}

void StaticLayers::hand_over(CameraId camera, const scene::PlacedScene& scene) {
    // What is shadowed is geometry, which belongs to the scene that it was placed in.
    if (auto kept = table_.take(camera); kept && kept->layer.shadowed == nullptr && seen_.is_of(camera, scene))
        handed_->put(camera, this, {std::move(*kept), scene.snapshot()->statics}, max_bytes_);
    seen_.forget(camera);
    table_.forget(camera);
}

void StaticLayers::clear() {
    seen_.clear();
    table_.clear();
}

}  // namespace camrig::render::software
