#pragma once

#include <memory>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/world/baked/baked_light.h"
#include "core/world/daylight_spec.h"
#include "core/world/fog_spec.h"
#include "core/world/look.h"
#include "core/world/model.h"
#include "core/world/posed_model.h"

namespace camrig::world {

/// What seldom changes about an object while it lives: then it gets another one.
struct ObjectInfo {
    ObjectId id{};
    std::string name;
    std::string object_class;        ///< "person", "vehicle", "furniture", ...; free text of the scene
    std::uint32_t class_number = 0;  ///< of the class, from 1 in the order in which this world first met them
    ModelRef model;
    /// What Instance::orientation holds beside the object's heading: the turn that makes the model face +x.
    glm::dquat heading_from_model{1.0, 0.0, 0.0, 0.0};
    std::string model_name = {};  ///< in the scene
    Look look = {};
};

/// One object at one instant. World placement in double: world_from_model = T(position) * R(orientation) * scale.
struct Instance {
    std::shared_ptr<const ObjectInfo> info;
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
    double scale = 1.0;
    glm::dvec3 velocity{0.0};      ///< m/s, world
    std::vector<ClipState> clips;  ///< empty: rest pose
};

/// A light in the world, as shading uses it: diffuse radiance = albedo * max(0, n.l) * color * intensity * attenuation
/// (the 1/pi of Lambert is folded into intensity). Attenuation and range as in KHR_lights_punctual.
struct Light {
    std::string name;
    std::string group;  ///< of lamps that are switched as one and are alike in colour and strength; empty: none
    LightType type = LightType::directional;
    glm::vec3 color{1.0f};
    float intensity = 1.0f;
    glm::dvec3 position{0.0};
    glm::dvec3 direction{0.0, 0.0, -1.0};  ///< unit, the way the light travels
    float range = 0.0f;
    float inner_cone_rad = 0.0f;
    float outer_cone_rad = 0.7853982f;
    /// Of a lamp on the mains: intensity * (1 + flicker_depth * sin(2 pi flicker_hz t)), for cameras with a sensor.
    float flicker_depth = 0.0f;
    double flicker_hz = 100.0;
    friend bool operator==(const Light&, const Light&) = default;
};

/// What actions call it by.
inline const std::string& switch_name(const Light& light) {
    return light.group.empty() ? light.name : light.group;
}

/// Linear RGB throughout.
struct Environment {
    glm::vec3 background{0.6f, 0.7f, 0.8f};
    glm::vec3 ambient_sky{0.5f};     ///< hemisphere ambient from +z; multiplies albedo * occlusion
    glm::vec3 ambient_ground{0.3f};  ///< from -z
    float exposure = 1.0f;           ///< factor on linear colour before the sRGB curve
    /// What is unlit or emissive lights others as if it were so much brighter than it is drawn, where there is baked
    /// light.
    float glow = 1.0f;
    /// Illuminance of a white surface that is drawn as linear 1, for cameras with a sensor; nullopt: not known.
    std::optional<double> lux{};
    /// What of this comes from sun and sky (apply_daylight); nullopt: nothing.
    std::optional<DaylightSpec> daylight{};
    FogSpec fog{};
    friend bool operator==(const Environment&, const Environment&) = default;
};

/// What does not move between commands, shared by all snapshots until a command or an event puts another in its place.
struct StaticSet {
    std::vector<Instance> objects;
    std::vector<Light> lights;
    Environment environment;
    std::vector<Instance> hidden = {};  ///< objects that nobody sees
    BakedLightRef baked_light = {};     ///< null: none
};

/// The world at one instant: light, immutable, complete. Everything drawn or told about this instant comes from here.
struct Snapshot {
    TimeNs world_ns = 0;
    std::shared_ptr<const StaticSet> statics;
    std::vector<Instance> movers;
    std::vector<Instance> hidden = {};  ///< movers that nobody sees
};

using SnapshotRef = std::shared_ptr<const Snapshot>;

}  // namespace camrig::world
