#pragma once

#include <map>
#include <memory>
#include <string>

#include "core/world/behaviour/behaviour.h"
#include "core/world/behaviour_spec.h"
#include "core/world/route_path.h"
#include "core/world/scene.h"
#include "core/world/walk/walk_area.h"

namespace camrig::world {

/// Makes behaviours from what check_behaviour() has found good; keeps the paths and areas that they share. Outlives
/// them. Thread: the world's.
class BehaviourFactory {
public:
    struct ForActor {
        ModelRef model;
        double radius_m = 0.0;
    };

    explicit BehaviourFactory(SceneRef scene) : scene_(std::move(scene)) {}
    /// With what the other has made so far; behaviours of the other stay its own (Behaviour::copy).
    BehaviourFactory(const BehaviourFactory&) = default;
    BehaviourFactory& operator=(const BehaviourFactory&) = delete;

    /// `joins`: the actor is somewhere already; to a route it walks first, by open ground. (Vehicles are put on
    /// theirs.)
    std::unique_ptr<Behaviour> make(const BehaviourSpec& spec, const ForActor& actor, bool joins);

    std::shared_ptr<const RoutePath> path_of(const std::string& route, double speed_m_s);
    /// Null for an empty name.
    std::shared_ptr<const WalkArea> area_of(const std::string& area, double radius_m);

private:
    template <typename Key, typename Value>
    using Shared = std::map<std::pair<std::string, Key>, std::shared_ptr<const Value>>;

    SceneRef scene_;
    Shared<double, RoutePath> paths_;
    Shared<int, WalkArea> areas_;
};

}  // namespace camrig::world
