#include "core/render/renderer.h"

namespace camrig::render {

RenderCounters& RenderCounters::operator+=(const RenderCounters& other) {
    layers += other.layers;
    layer_bytes += other.layer_bytes;
    draw_data_bytes += other.draw_data_bytes;
    layers_drawn += other.layers_drawn;
    layers_reused += other.layers_reused;
    layers_stale += other.layers_stale;
    layers_evicted += other.layers_evicted;
    views += other.views;
    views_in_parts += other.views_in_parts;
    meshes_skinned += other.meshes_skinned;
    meshes_unseen += other.meshes_unseen;
    draws += other.draws;
    draw_calls += other.draw_calls;
    draws_coarse += other.draws_coarse;
    conversions += other.conversions;
    return *this;
}

}  // namespace camrig::render
