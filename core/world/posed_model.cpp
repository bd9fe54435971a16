#include "core/world/posed_model.h"

#include <algorithm>

#include "core/base/result.h"
#include "core/world/interpolate.h"

namespace camrig::world {
namespace {

// glTF is y up, the world z up (REP 103): (x, y, z) -> (x, -z, y), columns below.
const glm::dmat4 world_from_gltf(1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0);

/// The animated values of all nodes; kept per thread, so that posing allocates nothing once it has seen a model.
struct Locals {
    std::vector<Transform> transforms;
    std::vector<std::vector<float>> weights;
};

const std::vector<float>* rest_weights(const Model& model, const Node& node) {
    if (node.mesh < 0) return nullptr;
    const auto& of_mesh = model.meshes[static_cast<std::size_t>(node.mesh)].weights;
    if (of_mesh.empty()) return nullptr;
    return node.weights.empty() ? &of_mesh : &node.weights;
}

void set_rest(const Model& model, Locals& out) {
    out.transforms.resize(model.nodes.size());
    out.weights.resize(model.nodes.size());
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
        out.transforms[i] = model.nodes[i].local;
        if (const auto* weights = rest_weights(model, model.nodes[i]))
            out.weights[i].assign(weights->begin(), weights->end());
        else
            out.weights[i].clear();
    }
}

void apply_clip(const Animation& animation, TimeNs phase_ns, Locals& out) {
    for (const Channel& channel : animation.channels) {
        const auto node = static_cast<std::size_t>(channel.node);
        switch (channel.path) {
            case ChannelPath::translation:
                out.transforms[node].translation = sample_vector(channel, phase_ns);
                break;
            case ChannelPath::scale:
                out.transforms[node].scale = sample_vector(channel, phase_ns);
                break;
            case ChannelPath::rotation:
                out.transforms[node].rotation = sample_rotation(channel, phase_ns);
                break;
            case ChannelPath::weights:
                sample_weights(channel, phase_ns, out.weights[node]);
                break;
        }
    }
}

/// into = mix(into, from, share), node by node.
void blend(const Locals& from, double share, Locals& into) {
    for (std::size_t i = 0; i < into.transforms.size(); ++i) {
        Transform& to = into.transforms[i];
        to.translation = glm::mix(to.translation, from.transforms[i].translation, share);
        to.scale = glm::mix(to.scale, from.transforms[i].scale, share);
        to.rotation = slerp_shortest(to.rotation, from.transforms[i].rotation, share);
        for (std::size_t w = 0; w < into.weights[i].size(); ++w) {
            float& weight = into.weights[i][w];
            weight = static_cast<float>(glm::mix(double{weight}, double{from.weights[i][w]}, share));
        }
    }
}

glm::dmat4 matrix_of(const Transform& t) {
    const glm::dmat3 rotation = glm::mat3_cast(t.rotation);
    return {glm::dvec4(rotation[0] * t.scale.x, 0.0), glm::dvec4(rotation[1] * t.scale.y, 0.0),
            glm::dvec4(rotation[2] * t.scale.z, 0.0), glm::dvec4(t.translation, 1.0)};
}

}  // namespace

void pose_model(const Model& model, std::span<const ClipState> clips, PosedModel& out) {
    static thread_local Locals pose, other;
    set_rest(model, pose);
    // Running blend: after clip k the pose is the mean of clips 0..k by their weights.
    double total = 0.0;
    for (const ClipState& clip : clips) {
        if (!(clip.weight > 0.0)) continue;
        CHECK(clip.animation >= 0 && clip.animation < std::ssize(model.animations));
        const Animation& animation = model.animations[static_cast<std::size_t>(clip.animation)];
        const bool first = total == 0.0;
        Locals& target = first ? pose : other;
        if (!first) set_rest(model, other);
        apply_clip(animation, clip.phase_ns, target);
        total += clip.weight;
        if (!first) blend(other, clip.weight / total, pose);
    }

    out.model_from_node.assign(model.nodes.size(), glm::dmat4(1.0));
    out.morph_weights.resize(model.nodes.size());
    for (const int index : model.order) {
        const auto i = static_cast<std::size_t>(index);
        const Node& node = model.nodes[i];
        const glm::dmat4 local = node.has_matrix ? node.matrix : matrix_of(pose.transforms[i]);
        const glm::dmat4& parent =
            node.parent < 0 ? world_from_gltf : out.model_from_node[static_cast<std::size_t>(node.parent)];
        out.model_from_node[i] = parent * local;
    }
    for (std::size_t i = 0; i < model.nodes.size(); ++i)
        out.morph_weights[i].assign(pose.weights[i].begin(), pose.weights[i].end());
}

bool is_deformed(const Model& model, int node) {
    const Node& n = model.nodes[static_cast<std::size_t>(node)];
    if (n.mesh < 0) return false;
    return n.skin >= 0 || !model.meshes[static_cast<std::size_t>(n.mesh)].weights.empty();
}

}  // namespace camrig::world
