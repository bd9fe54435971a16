#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>

#include "core/render/scene/reflections.h"
#include "core/render/software/software_model.h"
#include "core/world/snapshot.h"

namespace camrig::render::software {

/// Baked light of a scene as pixels take it.
struct BakedPicture {
    world::BakedLightRef light;
    std::vector<glm::vec3> weights;  ///< of its layers
    SoftwareImage map;
    float scale = 1.0f;  ///< of the map's light
    std::vector<world::LightProbe> probes;
    scene::ReflectionMaps reflections;
    std::shared_ptr<const scene::ProbeSights> sights;                 ///< of the light, whatever its sources send out
    std::map<const world::Primitive*, SampledTexture> of_primitives;  ///< the map, with the coordinates of each
    std::set<const world::Model*> models;                             ///< of which those are all
};

/// The last of each state of the lamps, made when a picture of quality beautiful needs it. Thread: any.
class BakedPictures {
public:
    /// null: the scene has no baked light. lamps_hz: as of layer_weights().
    std::shared_ptr<const BakedPicture> of(const world::StaticSet& statics, double lamps_hz = 0.0);

private:
    std::mutex mutex_;
    std::map<double, std::shared_ptr<const BakedPicture>> last_;  ///< by lamps_hz, of one light
};

}  // namespace camrig::render::software
