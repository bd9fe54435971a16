#include "core/world/gltf/animation_reader.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace camrig::world::gltf {
namespace {

Interpolation interpolation_of(const std::string& name, const std::string& place) {
    if (name == "LINEAR") return Interpolation::linear;
    if (name == "STEP") return Interpolation::step;
    if (name == "CUBICSPLINE") return Interpolation::cubic_spline;
    fail(place + ".interpolation", "'" + name.substr(0, 40) + "' is none of STEP, LINEAR, CUBICSPLINE");
}

std::vector<TimeNs> read_times(const AccessorReader& accessors, int accessor, const std::string& place) {
    require(accessors.count(accessor, place) <= max_keys, place, "more than " + std::to_string(max_keys) + " keys");
    const auto seconds = accessors.floats(accessor, 1, float32, place);
    std::vector<TimeNs> times;
    times.reserve(seconds.size());
    for (const float s : seconds) {
        require(s >= 0.0f && s <= max_clip_s, place, "a key time is negative or over 1e6 s");
        times.push_back(std::llround(static_cast<double>(s) * 1e9));
        require(times.size() < 2 || times.back() > times[times.size() - 2], place, "key times do not rise");
    }
    return times;
}

/// Rotations between which only directions count are made unit here; tangents and spline values stay as they are.
void normalise_rotations(Channel& channel, const std::string& place) {
    const std::size_t stride = channel.interpolation == Interpolation::cubic_spline ? 12 : 4;
    const std::size_t first = stride == 12 ? 4 : 0;
    for (std::size_t i = first; i + 4 <= channel.values.size(); i += stride) {
        float* q = channel.values.data() + i;
        const double length = std::sqrt(static_cast<double>(q[0]) * q[0] + static_cast<double>(q[1]) * q[1] +
                                        static_cast<double>(q[2]) * q[2] + static_cast<double>(q[3]) * q[3]);
        require(length > 1e-6, place, "a rotation key is a zero quaternion");
        if (stride == 4)
            for (int c = 0; c < 4; ++c) q[c] = static_cast<float>(q[c] / length);
    }
}

Channel read_channel(const tinygltf::AnimationChannel& from, const tinygltf::Animation& animation, const Model& model,
                     const AccessorReader& accessors, const std::string& place) {
    Channel channel;
    require(from.target_node >= 0 && from.target_node < std::ssize(model.nodes), place + ".target.node",
            "node " + std::to_string(from.target_node) + " of " + std::to_string(model.nodes.size()));
    require(from.sampler >= 0 && from.sampler < std::ssize(animation.samplers), place + ".sampler",
            "sampler " + std::to_string(from.sampler) + " of " + std::to_string(animation.samplers.size()));
    channel.node = from.target_node;
    const Node& node = model.nodes[static_cast<std::size_t>(channel.node)];
    const auto& sampler = animation.samplers[static_cast<std::size_t>(from.sampler)];
    const unsigned normalised = float32 | int8_normalised | uint8_normalised | int16_normalised | uint16_normalised;
    unsigned allowed = float32;
    int per_element = 3;
    if (from.target_path == "translation") {
        channel.path = ChannelPath::translation;
    } else if (from.target_path == "scale") {
        channel.path = ChannelPath::scale;
    } else if (from.target_path == "rotation") {
        channel.path = ChannelPath::rotation;
        channel.width = per_element = 4;
        allowed = normalised;
    } else if (from.target_path == "weights") {
        channel.path = ChannelPath::weights;
        const std::size_t targets =
            node.mesh >= 0 ? model.meshes[static_cast<std::size_t>(node.mesh)].weights.size() : 0;
        require(targets > 0, place + ".target", "animates morph weights of a node without morph targets");
        channel.width = static_cast<int>(targets);
        per_element = 1;
        allowed = normalised;
    } else {
        fail(place + ".target.path",
             "'" + from.target_path.substr(0, 40) + "' is none of translation, rotation, scale, weights");
    }
    require(channel.path == ChannelPath::weights || !node.has_matrix, place + ".target.node",
            "animates a node that has a matrix");

    channel.interpolation = interpolation_of(sampler.interpolation, place);
    channel.times_ns = read_times(accessors, sampler.input, place + ".input");
    channel.values = accessors.floats(sampler.output, per_element, allowed, place + ".output");
    const std::size_t per_key =
        static_cast<std::size_t>(channel.width) * (channel.interpolation == Interpolation::cubic_spline ? 3 : 1);
    require(channel.values.size() == channel.times_ns.size() * per_key, place + ".output",
            std::to_string(channel.values.size()) + " numbers for " + std::to_string(channel.times_ns.size()) +
                " keys of " + std::to_string(per_key));
    if (channel.path == ChannelPath::rotation) normalise_rotations(channel, place + ".output");
    return channel;
}

double ground_speed(const nlohmann::json& animation, const std::string& place) {
    const nlohmann::json::json_pointer pointer("/extras/ground_speed_m_s");
    if (!animation.contains(pointer)) return 0.0;
    const auto& value = animation[pointer];
    // Whom a clip carries slower than that it would take years over a step.
    constexpr double least_m_s = 0.001, most_m_s = 1000.0;
    const double speed = value.is_number() ? value.get<double>() : -1.0;
    require(speed == 0.0 || (speed >= least_m_s && speed <= most_m_s), place + ".extras.ground_speed_m_s",
            "expected a number from 0.001 to 1000, or 0");
    return speed;
}

}  // namespace

std::vector<Animation> read_animations(const Document& document, const AccessorReader& accessors, const Model& model) {
    std::vector<Animation> out;
    for (std::size_t a = 0; a < document.gltf.animations.size(); ++a) {
        const tinygltf::Animation& from = document.gltf.animations[a];
        const std::string place = item("animations", a);
        Animation animation;
        // Clips are asked for by name, so each has one.
        animation.name = from.name.empty() ? "clip_" + std::to_string(a) : from.name.substr(0, max_name_bytes);
        std::set<std::pair<int, ChannelPath>> targets;
        for (std::size_t c = 0; c < from.channels.size(); ++c) {
            const std::string at = item(place + ".channels", c);
            Channel channel = read_channel(from.channels[c], from, model, accessors, at);
            require(targets.emplace(channel.node, channel.path).second, at + ".target",
                    "another channel of this animation moves the same node and path");
            animation.duration_ns = std::max(animation.duration_ns, channel.times_ns.back());
            animation.channels.push_back(std::move(channel));
        }
        animation.ground_speed_m_s = ground_speed(document.json["animations"][a], place);
        out.push_back(std::move(animation));
    }
    return out;
}

}  // namespace camrig::world::gltf
