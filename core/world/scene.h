#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/world/camera_spec.h"
#include "core/world/snapshot.h"

namespace camrig {

/// A route over the floor: a polyline of world points.
struct Route {
    std::vector<glm::dvec3> points;
    bool closed = false;
};

/// Walks along a route at constant speed with smooth turns; the clip's speed follows the ground speed.
struct RouteBehaviour {
    enum class Mode : std::uint8_t { loop, ping_pong, once };
    std::string route;
    double speed_m_s = 1.3;
    double start_m = 0.0;
    Mode mode = Mode::loop;
    std::string clip;  ///< empty: no animation
};

/// Stays where it is and plays a clip in a loop.
struct StandBehaviour {
    std::string clip;
};

using BehaviourSpec = std::variant<StandBehaviour, RouteBehaviour>;

struct ActorSpec {
    std::string name;
    std::string object_class = "object";
    std::string model;
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
    double scale = 1.0;
    BehaviourSpec behaviour;
};

struct ObjectSpec {
    std::string name;
    std::string object_class = "object";
    std::string model;
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
    double scale = 1.0;
    std::string clip;  ///< not empty: a node animation played in a loop, which makes the object a mover
};

/// A named viewpoint that camera.create can refer to.
struct Place {
    std::string description;
    Pose pose;
    double vfov_rad = 1.0471975511965976;
};

struct SceneModel {
    ModelRef model;
    /// Turns the model so that its front faces +x (heading 0) when an actor moves it.
    glm::dquat heading_from_model{1.0, 0.0, 0.0, 0.0};
};

/// A scene file (or a bare glTF) with all its assets loaded; immutable.
struct Scene {
    std::string name;
    std::string description;
    std::filesystem::path file;
    std::uint64_t seed = 1;
    TimeNs step_ns = 10 * ns_per_ms;
    Environment environment;
    std::map<std::string, SceneModel> models;
    std::vector<ObjectSpec> objects;
    std::vector<ActorSpec> actors;
    std::vector<Light> lights;
    std::map<std::string, Route> routes;
    std::map<std::string, Place> places;
    std::vector<CameraSpec> cameras;  ///< created when the scene is loaded
};

using SceneRef = std::shared_ptr<const Scene>;

/// Loads a scene file (.json) or a bare .gltf/.glb. Errors name the file and the JSON path. A bare model becomes one
/// object, with its own lights and cameras if it has some, else default lights and one camera `main` that sees all of
/// it.
Result<SceneRef> load_scene(const std::filesystem::path& file);

}  // namespace camrig
