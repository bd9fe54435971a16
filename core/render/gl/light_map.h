#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/render/gl/gl_objects.h"
#include "core/render/scene/placed_scene.h"

namespace camrig::render::gl {

/// Baked light of a scene as it is now, for pictures of quality `beautiful`: the map on the device, and what is in the
/// open and in mirrors. Nothing of it is there before a scene with baked light is drawn at that quality.
class LightMap {
public:
    explicit LightMap(const GlFunctions& gl) : gl_(gl) {}

    /// Becomes that of the scene: made anew where its light is another one, or the colours and strengths of its sources
    /// are. Throws std::bad_alloc when the device has no memory left (GlRenderer::draw catches it).
    void update(const world::StaticSet& statics);

    bool is_there() const { return light_ != nullptr; }
    GLuint texture() const { return texture_.name(); }
    ImageSize size() const { return light_->size; }
    float scale() const { return scale_; }  ///< light of a full code
    /// Of the reflection probes, world.
    std::span<const glm::vec3> reflection_places() const { return light_->reflection_probes.places; }
    /// scene::ReflectionMaps and what probes see how near, on the device; 0: there are no such probes.
    GLuint reflection_texels() const { return reflection_texels_.name(); }
    GLuint nearness() const { return nearness_.name(); }
    /// Light where something is that has none of the map.
    world::LightProbe around(const scene::PlacedSurface& surface, const world::Environment& environment) const;

private:
    const GlFunctions& gl_;
    world::BakedLightRef light_;
    std::vector<glm::vec3> weights_;  ///< of its layers
    GlTexture texture_;
    GlBuffer reflection_texels_, nearness_;
    float scale_ = 1.0f;
    std::vector<world::LightProbe> probes_;
};

}  // namespace camrig::render::gl
