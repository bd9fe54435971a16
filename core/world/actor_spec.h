#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/world/behaviour_spec.h"

namespace camrig::world {

/// A thing that hangs on a node of an actor, e.g. a bag in a hand.
struct Attachment {
    std::string actor;
    std::string node;  ///< empty: the actor's origin
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
};

/// The class of those who keep to what the backdrops of a scene say is walkable.
inline constexpr std::string_view person_class = "person";
/// People take this much of the floor: half the breadth of shoulders and arms.
inline constexpr double person_radius_m = 0.28;

/// Something that moves: as a scene file or actor.spawn gives it.
struct ActorSpec {
    std::string name;
    std::string object_class = "object";
    std::string model;
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
    double scale = 1.0;
    std::optional<std::uint64_t> variant = {};  ///< of its model's look; nullopt: as its file has it
    std::optional<double> radius_m = {};        ///< of its body, for those who walk round it; nullopt: by its class
    std::optional<Attachment> attach = {};
    BehaviourSpec behaviour;
};

/// The fields of actor.set; what is empty stays as it is.
struct ActorPatch {
    std::string name;
    std::optional<glm::dvec3> position = {};
    std::optional<glm::dquat> orientation = {};
    std::optional<std::uint64_t> variant = {};
    std::optional<BehaviourSpec> behaviour = {};
    std::optional<Attachment> attach = {};
    bool detach = false;
    std::optional<std::string> play = {};  ///< a clip over the one of the behaviour; empty: no longer
    double play_speed = 1.0;
};

/// One actor of actor.steer.
struct SteerSpec {
    std::string name;
    std::optional<glm::dvec3> velocity = {};  ///< m/s; holds until the next steer
    std::optional<glm::dvec3> position = {};  ///< reached after `over_ns`
    TimeNs over_ns = 0;
    std::optional<double> yaw_rad = {};    ///< nullopt: the way it moves
    std::optional<std::string> clip = {};  ///< nullopt: as it is
};

/// An actor as it is now.
struct ActorReport {
    std::uint32_t id = 0;
    std::string name;
    std::string object_class;
    std::string model;
    double scale = 1.0;
    std::optional<std::uint64_t> variant = {};
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
    glm::dvec3 velocity{0.0};
    std::string behaviour;  ///< its type
    bool arrived = false;
    std::string clip;         ///< the one with the most weight
    std::string attached_to;  ///< empty: nothing
};

}  // namespace camrig::world
