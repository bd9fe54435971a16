#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/world/snapshot.h"

/// Things of the world by name, whether they move or not: what object.* tell and take.
namespace camrig::world {

/// The fields of object.set; what is empty stays as it is.
struct ObjectPatch {
    std::string name;
    std::optional<bool> hidden = {};
    std::optional<double> scale = {};
    std::optional<glm::dvec3> position = {};  ///< of actors actor.set says it
    std::optional<glm::dquat> orientation = {};
};

/// An object or an actor at one instant.
struct ObjectReport {
    std::uint32_t id = 0;
    std::string name;
    std::string object_class;
    std::string model;   ///< its name in the scene
    bool moves = false;  ///< an actor, or an object that plays a clip or was picked up
    bool hidden = false;
    double scale = 1.0;
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};  ///< of an actor: its front is +x
};

/// All of them, by id.
std::vector<ObjectReport> objects_of(const Snapshot& snapshot);
/// Null if it is not there; `report`, if it is not null, gets what is told of it.
const Instance* find_object(const Snapshot& snapshot, std::string_view name, ObjectReport* report = nullptr);

}  // namespace camrig::world
