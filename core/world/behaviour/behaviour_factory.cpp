#include "core/world/behaviour/behaviour_factory.h"

#include <algorithm>
#include <cmath>

#include "core/world/behaviour/route_behaviour.h"
#include "core/world/behaviour/sequence.h"
#include "core/world/behaviour/stand_behaviour.h"
#include "core/world/behaviour/steered.h"
#include "core/world/behaviour/vehicle.h"
#include "core/world/behaviour/walk_behaviours.h"

namespace camrig::world {
namespace {

/// Corners are taken wider at speed; steps of half a metre, so that actors of one route share its path.
double corner_radius_m(double speed_m_s) {
    return std::max(0.5, 0.5 * std::ceil(speed_m_s / 3.0));
}

/// Who plans a way keeps a bit more off the walls than its body needs.
constexpr double spare_m = 0.07;
constexpr double clearance_step_m = 0.05;

int clip_index(const Model& model, const std::string& name) {
    return name.empty() ? -1 : model.find_animation(name);
}

/// Makes the behaviour of each kind.
struct Make {
    BehaviourFactory& factory;
    const Scene& scene;
    const BehaviourFactory::ForActor& actor;
    bool joins;

    Gait::Options gait(const std::string& clip, const std::string& idle_clip) const {
        return {.model = actor.model,
                .clip = clip_index(*actor.model, clip),
                .idle_clip = clip_index(*actor.model, idle_clip)};
    }
    Walker walker(const WalkManner& walk) const {
        return Walker({.area = factory.area_of(walk.area, actor.radius_m),
                       .speed_m_s = walk.speed_m_s,
                       .gait = gait(walk.clip, walk.idle_clip)});
    }

    std::unique_ptr<Behaviour> operator()(const StandBehaviour& stand) const {
        return std::make_unique<Standing>(actor.model, clip_index(*actor.model, stand.clip));
    }
    std::unique_ptr<Behaviour> operator()(const RouteBehaviour& route) const {
        using Mode = RouteBehaviour::Mode;
        const auto path = factory.path_of(route.route, route.speed_m_s);
        const bool closed = scene.routes.at(route.route).closed;
        auto walk = std::make_unique<RouteWalk>(
            RouteWalk::Options{.path = path,
                               .mode = route.mode.value_or(closed ? Mode::loop : Mode::ping_pong),
                               .speed_m_s = route.speed_m_s,
                               .start_m = route.start_m,
                               .model = actor.model,
                               .animation = clip_index(*actor.model, route.clip)});
        if (!joins) return walk;
        const RoutePath::Point begin = walk->begin();
        Walker approach({.area = nullptr, .speed_m_s = route.speed_m_s, .gait = gait(route.clip, "")});
        auto go = std::make_unique<GoTo>(std::move(approach), glm::dvec2(begin.position), begin.heading_rad);
        return std::make_unique<JoinRoute>(std::move(go), std::move(walk), route.speed_m_s);
    }
    std::unique_ptr<Behaviour> operator()(const GoToBehaviour& go) const {
        return std::make_unique<GoTo>(walker(go.walk), glm::dvec2(go.position), go.yaw_rad);
    }
    std::unique_ptr<Behaviour> operator()(const WanderBehaviour& wander) const {
        return std::make_unique<Wander>(walker(wander.walk), factory.area_of(wander.walk.area, actor.radius_m),
                                        wander.pause_s);
    }
    std::unique_ptr<Behaviour> operator()(const LookAtBehaviour& look) const {
        return std::make_unique<LookAt>(Gait(gait("", look.clip)), look.actor, glm::dvec2(look.position));
    }
    std::unique_ptr<Behaviour> operator()(const FollowBehaviour& follow) const {
        return std::make_unique<Follow>(walker(follow.walk), follow.actor, follow.distance_m);
    }
    std::unique_ptr<Behaviour> operator()(const GroupBehaviour& group) const {
        return std::make_unique<Grouped>(walker(group.walk), group);
    }
    std::unique_ptr<Behaviour> operator()(const VehicleBehaviour& vehicle) const {
        return std::make_unique<Vehicle>(Vehicle::Options{.path = factory.path_of(vehicle.route, vehicle.speed_m_s),
                                                          .closed = scene.routes.at(vehicle.route).closed,
                                                          .spec = vehicle,
                                                          .model = actor.model,
                                                          .animation = clip_index(*actor.model, vehicle.clip),
                                                          .joins = joins});
    }
    std::unique_ptr<Behaviour> operator()(const SteeredBehaviour& steered) const {
        return std::make_unique<Steered>(gait(steered.clip, ""));
    }
    std::unique_ptr<Behaviour> operator()(const SequenceBehaviour& sequence) const {
        return std::make_unique<Sequence>(sequence, factory, actor);
    }
};

}  // namespace

std::unique_ptr<Behaviour> BehaviourFactory::make(const BehaviourSpec& spec, const ForActor& actor, bool joins) {
    return std::visit(Make{*this, *scene_, actor, joins}, spec);
}

std::shared_ptr<const RoutePath> BehaviourFactory::path_of(const std::string& route, double speed_m_s) {
    const double radius = corner_radius_m(speed_m_s);
    auto& path = paths_[{route, radius}];
    if (!path) {
        auto created = RoutePath::create(scene_->routes.at(route), radius);
        CHECK(created.has_value());  // the scene's reader has tried it
        path = std::make_shared<RoutePath>(std::move(*created));
    }
    return path;
}

std::shared_ptr<const WalkArea> BehaviourFactory::area_of(const std::string& area, double radius_m) {
    if (area.empty()) return nullptr;
    const int steps = static_cast<int>(std::ceil((radius_m + spare_m) / clearance_step_m - 1e-9));
    auto& known = areas_[{area, steps}];
    if (!known) known = std::make_shared<WalkArea>(scene_->areas.at(area), steps * clearance_step_m);
    return known;
}

}  // namespace camrig::world
