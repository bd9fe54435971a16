#include "core/world/gltf/node_reader.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/json_reader.h"

namespace camrig::world::gltf {
namespace {

using nlohmann::json;

int checked_index(std::int64_t index, std::size_t size, const std::string& place, const char* what) {
    require(index < static_cast<std::int64_t>(size), place,
            std::string(what) + " " + std::to_string(index) + " of " + std::to_string(size));
    return static_cast<int>(std::max<std::int64_t>(index, -1));
}

/// Numbers of one member: absent, or exactly `size` of them, within max_value.
bool read_numbers(const json& node, const char* key, std::span<double> out, const std::string& place) {
    const auto found = node.find(key);
    if (found == node.end()) return false;
    const std::string at = place + "." + key;
    require(found->is_array() && found->size() == out.size(), at,
            "expected an array of " + std::to_string(out.size()) + " numbers");
    for (std::size_t i = 0; i < out.size(); ++i) {
        require((*found)[i].is_number(), at, "expected numbers");
        out[i] = (*found)[i].get<double>();
        require(std::abs(out[i]) <= max_value, at, "a number is not finite or over 1e10");
    }
    return true;
}

void read_transform(const json& from, Node& node, const std::string& place) {
    std::array<double, 16> m{};
    if (read_numbers(from, "matrix", m, place)) {
        require(m[3] == 0.0 && m[7] == 0.0 && m[11] == 0.0 && m[15] == 1.0, place + ".matrix",
                "the last row is not 0 0 0 1");
        node.has_matrix = true;
        for (glm::length_t column = 0; column < 4; ++column)
            for (glm::length_t row = 0; row < 4; ++row)
                node.matrix[column][row] = m[static_cast<std::size_t>(column * 4 + row)];
    }
    std::array<double, 3> v{};
    if (read_numbers(from, "translation", v, place)) node.local.translation = {v[0], v[1], v[2]};
    if (read_numbers(from, "scale", v, place)) node.local.scale = {v[0], v[1], v[2]};
    std::array<double, 4> q{};
    if (read_numbers(from, "rotation", q, place)) {
        const glm::dquat rotation(q[3], q[0], q[1], q[2]);
        const double length = glm::length(rotation);
        require(length > 1e-6, place + ".rotation", "is not a rotation (zero quaternion)");
        node.local.rotation = rotation / length;
    }
}

int max_joint(const Mesh& mesh) {
    int highest = -1;
    for (const Primitive& primitive : mesh.primitives)
        for (const glm::u16vec4& joints : primitive.joints)
            highest = std::max({highest, int{joints.x}, int{joints.y}, int{joints.z}, int{joints.w}});
    return highest;
}

Node read_node(const Document& document, std::size_t index, const Model& model, std::size_t lights) {
    const tinygltf::Node& from = document.gltf.nodes[index];
    const json& source = document.json["nodes"][index];
    const std::string place = item("nodes", index);
    Node node;
    node.name = from.name.substr(0, max_name_bytes);
    read_transform(source, node, place);
    node.mesh = checked_index(from.mesh, model.meshes.size(), place + ".mesh", "mesh");
    node.skin = checked_index(from.skin, model.skins.size(), place + ".skin", "skin");
    node.camera = checked_index(from.camera, model.cameras.size(), place + ".camera", "camera");
    if (node.mesh < 0) node.skin = -1;
    const json::json_pointer light_pointer("/extensions/KHR_lights_punctual/light");
    if (source.contains(light_pointer))
        node.light = checked_index(source[light_pointer].get<std::int64_t>(), lights, place + ".light", "light");
    const auto extra = [&](const char* pointer) {
        const json::json_pointer at(pointer);
        return source.contains(at) && source[at].is_string()
                   ? source[at].get_ref<const std::string&>().substr(0, max_name_bytes)
                   : std::string();
    };
    node.keypoint = extra("/extras/keypoint");
    node.proxy = extra("/extras/camrig_proxy");
    if (node.mesh < 0) return node;

    const Mesh& mesh = model.meshes[static_cast<std::size_t>(node.mesh)];
    require(
        from.weights.empty() || from.weights.size() == mesh.weights.size(), place + ".weights",
        std::to_string(from.weights.size()) + " weights for " + std::to_string(mesh.weights.size()) + " morph targets");
    for (const double weight : from.weights) {
        require(std::abs(weight) <= max_value, place + ".weights", "a weight is not finite");
        node.weights.push_back(static_cast<float>(weight));
    }
    return node;
}

/// A joint number beyond the skin would read outside the joint matrices.
void check_joints(const Model& model) {
    std::vector<int> highest(model.meshes.size(), -2);
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
        const Node& node = model.nodes[i];
        if (node.skin < 0) continue;
        int& joint = highest[static_cast<std::size_t>(node.mesh)];
        if (joint == -2) joint = max_joint(model.meshes[static_cast<std::size_t>(node.mesh)]);
        const auto joints = std::ssize(model.skins[static_cast<std::size_t>(node.skin)].joints);
        require(joint < joints, item("nodes", i),
                "its mesh uses joint " + std::to_string(joint) + " of " + std::to_string(joints) + " in its skin");
    }
}

void check_placed(const Model& model) {
    std::size_t vertices = 0, indices = 0, primitives = 0;
    const auto check = [](std::size_t count, std::size_t limit, const char* what) {
        if (count > limit)
            fail("nodes", "their meshes have more than " + std::to_string(limit) + " " + what + " in all",
                 ErrorKind::resource_exhausted);
    };
    for (const Node& node : model.nodes) {
        if (node.mesh < 0) continue;
        const auto& placed = model.meshes[static_cast<std::size_t>(node.mesh)].primitives;
        primitives += placed.size();
        check(primitives, max_placed_primitives, "primitives");
        for (const Primitive& primitive : placed) {
            vertices += primitive.positions.size();
            indices += primitive.indices.size();
        }
        check(vertices, max_placed_vertices, "vertices");
        check(indices, max_placed_indices, "indices");
    }
}

/// Sets parents and the order of the default scene. Without recursion: depth is the file's choice.
void read_hierarchy(const Document& document, Model& model) {
    const auto& nodes = document.gltf.nodes;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        for (const int child : nodes[i].children) {
            const std::string place = item("nodes", i) + ".children";
            require(child >= 0 && child < std::ssize(nodes), place,
                    "node " + std::to_string(child) + " of " + std::to_string(nodes.size()));
            Node& node = model.nodes[static_cast<std::size_t>(child)];
            require(node.parent < 0, place, "node " + std::to_string(child) + " has two parents");
            node.parent = static_cast<int>(i);
        }
    }
    // With one parent each, whatever a walk from the roots does not reach is a cycle.
    std::vector<int> depth(nodes.size(), -1);
    std::vector<int> all;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (model.nodes[i].parent >= 0) continue;
        depth[i] = 0;
        all.push_back(static_cast<int>(i));
    }
    for (std::size_t next = 0; next < all.size(); ++next) {
        const auto index = static_cast<std::size_t>(all[next]);
        for (const int child : nodes[index].children) {
            depth[static_cast<std::size_t>(child)] = depth[index] + 1;
            require(depth[index] < max_node_depth, item("nodes", static_cast<std::size_t>(child)),
                    "nested deeper than " + std::to_string(max_node_depth));
            all.push_back(child);
        }
    }
    require(all.size() == nodes.size(), "nodes", "the hierarchy has a cycle");

    if (document.gltf.scenes.empty()) {
        model.order = std::move(all);
        return;
    }
    const int scene = std::max(document.gltf.defaultScene, 0);
    require(scene < std::ssize(document.gltf.scenes), "scene",
            "scene " + std::to_string(scene) + " of " + std::to_string(document.gltf.scenes.size()));
    const std::string place = item("scenes", static_cast<std::size_t>(scene)) + ".nodes";
    std::vector<bool> seen(nodes.size());
    for (const int root : document.gltf.scenes[static_cast<std::size_t>(scene)].nodes) {
        require(root >= 0 && root < std::ssize(nodes), place,
                "node " + std::to_string(root) + " of " + std::to_string(nodes.size()));
        require(model.nodes[static_cast<std::size_t>(root)].parent < 0, place,
                "node " + std::to_string(root) + " is not a root");
        require(!seen[static_cast<std::size_t>(root)], place, "node " + std::to_string(root) + " stands there twice");
        seen[static_cast<std::size_t>(root)] = true;
        model.order.push_back(root);
    }
    for (std::size_t next = 0; next < model.order.size(); ++next) {
        const auto& children = nodes[static_cast<std::size_t>(model.order[next])].children;
        model.order.insert(model.order.end(), children.begin(), children.end());
    }
}

Skin read_skin(const Document& document, std::size_t index, const AccessorReader& accessors, Budget& budget) {
    const tinygltf::Skin& from = document.gltf.skins[index];
    const std::string place = item("skins", index);
    Skin skin;
    skin.name = from.name.substr(0, max_name_bytes);
    skin.joints = from.joints;
    require(!skin.joints.empty() && skin.joints.size() <= max_joints, place + ".joints",
            std::to_string(skin.joints.size()) + " joints; 1 to " + std::to_string(max_joints) + " are read");
    for (const int joint : skin.joints) {
        require(joint >= 0 && joint < std::ssize(document.gltf.nodes), place + ".joints",
                "node " + std::to_string(joint) + " of " + std::to_string(document.gltf.nodes.size()));
    }
    budget.take(skin.joints.size() * sizeof(glm::dmat4), place + ".joints");
    skin.inverse_bind.assign(skin.joints.size(), glm::dmat4(1.0));
    if (from.inverseBindMatrices < 0) return skin;
    const std::string at = place + ".inverseBindMatrices";
    const auto values = accessors.floats(from.inverseBindMatrices, 16, float32, at);
    require(values.size() / 16 >= skin.joints.size(), at,
            std::to_string(values.size() / 16) + " matrices for " + std::to_string(skin.joints.size()) + " joints");
    for (std::size_t j = 0; j < skin.joints.size(); ++j) {
        // The last row is 0 0 0 1 by the standard; exporters leave noise there.
        for (glm::length_t column = 0; column < 4; ++column)
            for (glm::length_t row = 0; row < 3; ++row)
                skin.inverse_bind[j][column][row] = values[j * 16 + static_cast<std::size_t>(column * 4 + row)];
    }
    return skin;
}

ModelCamera read_camera(const tinygltf::Camera& from, const std::string& place) {
    ModelCamera camera{.name = from.name.substr(0, max_name_bytes), .perspective = from.type == "perspective"};
    if (!camera.perspective) return camera;
    camera.yfov_rad = from.perspective.yfov;
    camera.aspect = from.perspective.aspectRatio;
    camera.near_m = from.perspective.znear;
    require(camera.yfov_rad > 0.0 && camera.yfov_rad < std::numbers::pi, place + ".perspective.yfov",
            "is not between 0 and pi");
    require(camera.aspect >= 0.0 && camera.aspect <= 1e4, place + ".perspective.aspectRatio", "is out of range");
    require(camera.near_m > 0.0 && camera.near_m <= max_value, place + ".perspective.znear", "is not positive");
    return camera;
}

/// KHR_lights_punctual, read here because tinygltf does not tell a missing intensity from 0.
ModelLight read_light(const json& from, const std::string& place) {
    JsonReader reader(from, place);
    ModelLight light;
    std::string type;
    std::array<double, 3> color{1.0, 1.0, 1.0};
    double intensity = 1.0, range = 0.0, inner = 0.0, outer = std::numbers::pi / 4.0;
    reader.optional("name", light.name);
    reader.required("type", type);
    if (reader.has("color")) reader.required("color", std::span<double>(color));
    reader.optional("intensity", intensity);
    reader.optional("range", range);
    const json* spot = reader.find("spot");
    for (const char* ignored : {"extras", "extensions"}) reader.find(ignored);
    if (auto done = reader.finish(); !done) throw Failure{done.error()};
    if (spot) {
        JsonReader cone(*spot, place + ".spot");
        cone.optional("innerConeAngle", inner);
        cone.optional("outerConeAngle", outer);
        for (const char* ignored : {"extras", "extensions"}) cone.find(ignored);
        if (auto done = cone.finish(); !done) throw Failure{done.error()};
    }
    light.name = light.name.substr(0, max_name_bytes);
    if (type == "directional") {
        light.type = LightType::directional;
    } else if (type == "spot") {
        light.type = LightType::spot;
        require(inner >= 0.0 && inner < outer && outer <= std::numbers::pi / 2.0 + 1e-6, place + ".spot",
                "cone angles must be 0 <= inner < outer <= pi/2");
    } else {
        require(type == "point", place + ".type", "is none of directional, point, spot");
    }
    for (const double part : color) require(part >= 0.0 && part <= 1e6, place + ".color", "is out of range");
    require(intensity >= 0.0 && intensity <= max_value, place + ".intensity", "is out of range");
    require(range >= 0.0 && range <= max_value, place + ".range", "is out of range");
    light.color = {color[0], color[1], color[2]};
    light.intensity = static_cast<float>(intensity);
    light.range = static_cast<float>(range);
    light.inner_cone_rad = static_cast<float>(inner);
    light.outer_cone_rad = static_cast<float>(outer);
    return light;
}

std::vector<ModelLight> read_lights(const json& root) {
    std::vector<ModelLight> out;
    const json::json_pointer lights_pointer("/extensions/KHR_lights_punctual/lights");
    if (!root.contains(lights_pointer)) return out;
    const json& lights = root[lights_pointer];
    const std::string place = "extensions.KHR_lights_punctual.lights";
    require(lights.is_array() && lights.size() <= max_items, place, "expected an array");
    for (std::size_t i = 0; i < lights.size(); ++i) out.push_back(read_light(lights[i], item(place, i)));
    return out;
}

}  // namespace

void read_nodes(const Document& document, const AccessorReader& accessors, Budget& budget, Model& model) {
    for (std::size_t i = 0; i < document.gltf.skins.size(); ++i)
        model.skins.push_back(read_skin(document, i, accessors, budget));
    for (std::size_t i = 0; i < document.gltf.cameras.size(); ++i)
        model.cameras.push_back(read_camera(document.gltf.cameras[i], item("cameras", i)));
    model.lights = read_lights(document.json);
    for (std::size_t i = 0; i < document.gltf.nodes.size(); ++i)
        model.nodes.push_back(read_node(document, i, model, model.lights.size()));
    check_placed(model);
    check_joints(model);
    read_hierarchy(document, model);
}

}  // namespace camrig::world::gltf
