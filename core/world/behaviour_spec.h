#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "core/base/time.h"

/// Behaviours as data: what a scene file or a command can ask of an actor. docs/scene-format.md explains each.
namespace camrig::world {

/// Stays where it is and plays a clip in a loop.
struct StandBehaviour {
    std::string clip;
};

/// Walks along a route at constant speed with smooth turns; the clip's speed follows the ground speed.
struct RouteBehaviour {
    enum class Mode : std::uint8_t { loop, ping_pong, once };
    std::string route;
    double speed_m_s = 1.3;
    double start_m = 0.0;
    std::optional<Mode> mode;  ///< nullopt: loop on closed routes, ping_pong on open ones
    std::string clip;          ///< empty: no animation
};

/// How somebody walks who finds the way himself, round others and round the obstacles of an area.
struct WalkManner {
    std::string area;  ///< empty: open ground without obstacles
    double speed_m_s = 1.3;
    std::string clip;       ///< while walking
    std::string idle_clip;  ///< while standing
};

/// Walks to a point and stays there.
struct GoToBehaviour {
    glm::dvec3 position{0.0};
    std::optional<double> yaw_rad;  ///< how it stands when it is there
    WalkManner walk;
};

/// Walks from one random point of an area to the next.
struct WanderBehaviour {
    double pause_s = 0.0;  ///< mean time that it stands at each point
    WalkManner walk;
};

/// Stays and turns to an actor or a point.
struct LookAtBehaviour {
    std::string actor;  ///< empty: the point
    glm::dvec3 position{0.0};
    std::string clip;
};

/// Walks behind another actor.
struct FollowBehaviour {
    std::string actor;
    double distance_m = 1.5;
    WalkManner walk{.area = {}, .speed_m_s = 1.6, .clip = {}, .idle_clip = {}};
};

/// All actors of one group stand in a circle and face its middle.
struct GroupBehaviour {
    std::string group;
    glm::dvec3 position{0.0};  ///< the middle
    double radius_m = 0.8;
    WalkManner walk;
};

/// Drives along a route and keeps its distance from whatever is on the lane ahead (IDM).
struct VehicleBehaviour {
    std::string route;
    double speed_m_s = 10.0;
    double start_m = 0.0;
    double length_m = 4.5;
    double width_m = 1.8;
    double headway_s = 1.5;
    double gap_m = 2.0;  ///< to what it stands behind
    double acceleration_m_s2 = 1.5;
    double braking_m_s2 = 2.5;
    std::string clip;
};

/// Moved by actor.steer, step by step.
struct SteeredBehaviour {
    std::string clip;
};

struct SequenceStep;

/// One behaviour after the other.
struct SequenceBehaviour {
    std::vector<SequenceStep> steps;
    bool repeat = false;
};

using BehaviourSpec =
    std::variant<StandBehaviour, RouteBehaviour, GoToBehaviour, WanderBehaviour, LookAtBehaviour, FollowBehaviour,
                 GroupBehaviour, VehicleBehaviour, SteeredBehaviour, SequenceBehaviour>;

/// Ends when it has arrived, or after a time, or when an event fires.
struct SequenceStep {
    BehaviourSpec behaviour;
    std::optional<TimeNs> duration_ns;
    std::string event;  ///< empty: none
};

/// The `type` of a behaviour in JSON.
std::string_view type_name(const BehaviourSpec& behaviour);
/// Whether the behaviour itself says where the actor begins.
bool places_actor(const BehaviourSpec& behaviour);

}  // namespace camrig::world
