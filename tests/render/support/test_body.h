#pragma once

#include "core/world/model_lights.h"
#include "tests/render/support/test_models.h"

namespace camrig::render {

/// A body of two joints (nodes 1 and 2), 1.2 m high: a leg of 0.2 x 0.2 x 0.8 m that stands on the origin, and on it a
/// cube of 0.4 m.
inline world::ModelRef leg_and_cube() {
    world::Primitive body;
    const auto add = [&](glm::vec3 half, float middle, std::uint16_t joint) {
        const world::Primitive part = box(half);
        const auto first = static_cast<std::uint32_t>(body.positions.size());
        for (const std::uint32_t index : part.indices) body.indices.push_back(first + index);
        for (const glm::vec3& position : part.positions)
            body.positions.push_back(position + glm::vec3(0.0f, 0.0f, middle));
        body.normals.insert(body.normals.end(), part.normals.begin(), part.normals.end());
        body.joints.resize(body.positions.size(), glm::u16vec4(joint, 0, 0, 0));
    };
    add({0.1f, 0.1f, 0.4f}, 0.4f, 0);
    add({0.2f, 0.2f, 0.2f}, 1.0f, 1);
    body.weights.assign(body.positions.size(), glm::vec4(1, 0, 0, 0));
    body.bounds = {{-0.2f, -0.2f, 0.0f}, {0.2f, 0.2f, 1.2f}};
    const auto model = model_of(std::move(body), colored(glm::vec3(0.5f)));
    model->nodes[0].skin = 0;
    const auto joint = [&](double z) {
        // The one node of model_of() undoes the loader's turn; so do joints.
        world::Node node = model->nodes[0];
        node.mesh = node.skin = -1;
        glm::dmat4 lifted(1.0);
        lifted[3] = {0.0, 0.0, z, 1.0};
        const glm::dmat4 own = node.has_matrix ? node.matrix : glm::dmat4(glm::mat3_cast(node.local.rotation));
        node.has_matrix = true;
        node.matrix = own * lifted;
        model->nodes.push_back(node);
        model->order.push_back(static_cast<int>(model->nodes.size()) - 1);
        return glm::inverse(lifted);
    };
    const glm::dmat4 leg = joint(0.4), cube = joint(1.0);
    model->skins.push_back({.name = "body", .joints = {1, 2}, .inverse_bind = {leg, cube}});
    return model;
}

}  // namespace camrig::render
