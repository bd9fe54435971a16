#include "core/render/gl/light_map.h"

#include <new>
#include <utility>

#include "core/render/scene/light_sum.h"
#include "core/render/scene/reflections.h"

namespace camrig::render::gl {
namespace {

/// Sky and ground by the normal: the same form.
world::LightProbe open_place(const world::Environment& environment) {
    const glm::vec3 sky = environment.ambient_sky * environment.exposure;
    const glm::vec3 ground = environment.ambient_ground * environment.exposure;
    world::LightProbe probe{.mean = 0.5f * (sky + ground)};
    probe.along[2] = 0.5f * (sky - ground);
    return probe;
}

/// None for nothing.
template <typename Value>
GlBuffer buffer_of(const GlFunctions& gl, const std::vector<Value>& values) {
    if (values.empty()) return {};
    GlBuffer buffer = make_buffer(gl);
    gl.NamedBufferStorage(buffer.name(), static_cast<GLsizeiptr>(values.size() * sizeof(Value)), values.data(), 0);
    return buffer;
}

}  // namespace

void LightMap::update(const world::StaticSet& statics) {
    if (statics.baked_light == nullptr) {
        light_.reset();
        texture_ = {};
        reflection_texels_ = {};
        nearness_ = {};
        probes_.clear();
        return;
    }
    std::vector<glm::vec3> weights = scene::layer_weights(statics);
    const bool is_same = light_ == statics.baked_light;
    if (is_same && weights_ == weights) return;
    const world::BakedLight& light = *statics.baked_light;
    const scene::LightMapSum sum = scene::sum_map(light, weights);
    if (!is_same) {
        light_.reset();
        texture_ = make_texture_2d(gl_);
        // One level: smaller ones would mix rectangles that lie beside each other.
        gl_.TextureStorage2D(texture_.name(), 1, GL_RGBA16, light.size.width, light.size.height);
    }
    gl_.TextureSubImage2D(texture_.name(), 0, 0, 0, light.size.width, light.size.height, GL_RGBA, GL_UNSIGNED_SHORT,
                          sum.texels.data());
    reflection_texels_ = buffer_of(gl_, scene::sum_reflections(light, weights).texels);
    if (!is_same) nearness_ = buffer_of(gl_, scene::bordered_nearness(light.reflection_probes));
    if (is_out_of_memory(gl_)) throw std::bad_alloc();
    scale_ = sum.scale;
    probes_ = scene::sum_probes(light, weights);
    weights_ = std::move(weights);
    light_ = statics.baked_light;
}

world::LightProbe LightMap::around(const scene::PlacedSurface& surface, const world::Environment& environment) const {
    return scene::probe_at(light_->grid, probes_, surface.middle()).value_or(open_place(environment));
}

}  // namespace camrig::render::gl
