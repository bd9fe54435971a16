#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/world/actor_spec.h"
#include "core/world/baked/baked_light.h"
#include "core/world/camera_spec.h"
#include "core/world/event/event_spec.h"
#include "core/world/snapshot.h"

namespace camrig::world {

/// A route over the floor: a polyline of world points.
struct Route {
    std::vector<glm::dvec3> points;
    bool closed = false;
};

/// A piece of floor with borders: people wander in it, events watch it. Corners in the plane, in either order; the
/// border does not cross itself.
struct Area {
    std::vector<glm::dvec2> points;
    std::vector<std::vector<glm::dvec2>> obstacles;  ///< nobody walks through them
    double z = 0.0;                                  ///< height of the floor
};

struct ObjectSpec {
    std::string name;
    std::string object_class = "object";
    std::string model;
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
    double scale = 1.0;
    std::string clip;  ///< not empty: a node animation played in a loop, which makes the object a mover
    std::optional<Attachment> attach;
};

/// A named viewpoint that camera.create can refer to.
struct Place {
    std::string description;
    camera::Pose pose;
    double vfov_rad = 1.0471975511965976;
};

struct SceneModel {
    ModelRef model;
    /// Turns the model so that its front faces +x (heading 0) when an actor moves it.
    glm::dquat heading_from_model{1.0, 0.0, 0.0, 0.0};
    bool is_photometric = false;  ///< its file's light was in the units of glTF (in_scene_units)
};

/// A scene file (or a bare glTF) with all its assets loaded; immutable.
struct Scene {
    std::string name;
    std::string description;
    std::filesystem::path file;
    std::vector<std::filesystem::path> bases;  ///< what that file stands on, nearest first
    std::uint64_t seed = 1;
    TimeNs step_ns = 10 * ns_per_ms;
    Environment environment;
    std::map<std::string, SceneModel> models;
    std::vector<ObjectSpec> objects;
    std::vector<ActorSpec> actors;
    std::vector<Light> lights;
    std::map<std::string, Route> routes;
    std::map<std::string, Area> areas;
    std::map<std::string, Place> places;
    std::vector<CameraSpec> cameras;  ///< created when the scene is loaded
    std::vector<EventSpec> events;
    BakedLightRef baked_light;  ///< null: none
};

using SceneRef = std::shared_ptr<const Scene>;

struct SceneOptions {
    /// Of a bare model: it stands on a ground under a sky.
    bool bare_ground = true;
    /// With the light that lies beside its file (core/world/baked).
    bool baked_light = true;
};

/// Loads a scene: the name of a shipped one (core/world/shipped.h), a scene file (.json) or a bare .gltf/.glb. Errors
/// name the file and the JSON path; the first one ends it. A bare model becomes one object, with its own lights and
/// cameras if it has some, else default lights and one camera `main` that sees all of it.
Result<SceneRef> load_scene(const std::filesystem::path& scene, const SceneOptions& options = {});

}  // namespace camrig::world
