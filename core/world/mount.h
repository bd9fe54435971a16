#pragma once

#include <string_view>

#include "core/camera/pose.h"
#include "core/world/snapshot.h"

namespace camrig::world {

/// The turn of a node of a posed model, scale left out, with z for its y, as the world is to glTF.
glm::dquat z_up_turn(const glm::dmat4& model_from_node);

/// world_from_mount of what is fixed to an actor at this instant. No node: the actor's body frame (x ahead, y left,
/// z up, at its origin). A node of its model: at the node, and turned against the body as the node is by its clips; at
/// rest, a node without a turn of its own has the body's axes. A name that the model does not have is no node.
camera::Pose mount_frame(const Instance& carrier, std::string_view node);

/// world_from_link of a pose given in a frame.
camera::Pose in_world(const camera::Pose& world_from_frame, const camera::Pose& frame_from_link);

}  // namespace camrig::world
