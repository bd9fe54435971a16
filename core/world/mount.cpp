#include "core/world/mount.h"

#include <algorithm>
#include <numbers>

namespace camrig::world {

namespace {

/// Of the quaternion of a quarter turn: cosine and sine of 45 degrees.
constexpr double quarter_turn_part = std::numbers::sqrt2 / 2.0;

}  // namespace

glm::dquat z_up_turn(const glm::dmat4& model_from_node) {
    glm::dmat3 axes(model_from_node);
    for (int i = 0; i < 3; ++i) axes[i] = glm::normalize(axes[i]);
    return glm::quat_cast(axes) * glm::dquat(quarter_turn_part, -quarter_turn_part, 0.0, 0.0);
}

camera::Pose mount_frame(const Instance& carrier, std::string_view node) {
    const glm::dquat model_from_body = glm::inverse(carrier.info->heading_from_model);
    const Model& model = *carrier.info->model;
    const auto found = node.empty() ? model.nodes.end() : std::ranges::find(model.nodes, node, &Node::name);
    if (found == model.nodes.end()) return {carrier.position, glm::normalize(carrier.orientation * model_from_body)};
    static thread_local PosedModel pose;
    pose_model(model, carrier.clips, pose);
    const glm::dmat4& placed = pose.model_from_node[static_cast<std::size_t>(found - model.nodes.begin())];
    return {carrier.position + carrier.orientation * (carrier.scale * glm::dvec3(placed[3])),
            glm::normalize(carrier.orientation * z_up_turn(placed) * model_from_body)};
}

camera::Pose in_world(const camera::Pose& world_from_frame, const camera::Pose& frame_from_link) {
    return {world_from_frame.position + world_from_frame.orientation * frame_from_link.position,
            glm::normalize(world_from_frame.orientation * frame_from_link.orientation)};
}

}  // namespace camrig::world
