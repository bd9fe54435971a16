#include "core/world/model_lights.h"

#include <numbers>

#include "core/world/posed_model.h"

namespace camrig::world {

glm::dmat4 world_from_model(const glm::dvec3& position, const glm::dquat& orientation, double scale) {
    const glm::dmat3 rotation = glm::mat3_cast(orientation);
    return {glm::dvec4(rotation[0] * scale, 0.0), glm::dvec4(rotation[1] * scale, 0.0),
            glm::dvec4(rotation[2] * scale, 0.0), glm::dvec4(position, 1.0)};
}

void append_model_lights(const Model& model, const ObjectSpec& object, std::vector<Light>& out) {
    if (model.lights.empty()) return;
    PosedModel pose;
    pose_model(model, {}, pose);
    const glm::dmat4 placement = world_from_model(object.position, object.orientation, object.scale);
    for (const int index : model.order) {
        const Node& node = model.nodes[static_cast<std::size_t>(index)];
        if (node.light < 0) continue;
        const ModelLight& from = model.lights[static_cast<std::size_t>(node.light)];
        const glm::dmat4 world = placement * pose.model_from_node[static_cast<std::size_t>(index)];
        const glm::dvec3 forward = -glm::dvec3(world[2]);  // lights shine along -z of their node
        const double length = glm::length(forward);
        if (!(length > 0.0)) continue;
        Light light;
        light.name = object.name + "." + (from.name.empty() ? node.name : from.name);
        light.type = from.type;
        light.color = from.color;
        light.intensity = static_cast<float>(from.intensity / std::numbers::pi);
        light.position = glm::dvec3(world[3]);
        light.direction = forward / length;
        light.range = from.range;
        light.inner_cone_rad = from.inner_cone_rad;
        light.outer_cone_rad = from.outer_cone_rad;
        out.push_back(std::move(light));
    }
}

}  // namespace camrig::world
