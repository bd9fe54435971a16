#include "core/world/backdrop/proxy_roles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "core/world/posed_model.h"

namespace camrig::world {
namespace {

constexpr std::string_view catcher_role = "catcher", holdout_role = "holdout", walkable_role = "walkable";
constexpr std::array shape_roles{std::string_view("ground"), std::string_view("obstacle"), std::string_view("wall"),
                                 catcher_role, holdout_role};
constexpr std::size_t most_walkable_triangles = 5000;

std::unexpected<Error> wrong(const Node& node, ErrorKind kind, const std::string& what) {
    return error(kind, "node '" + node.name + "': extras.camrig_proxy: " + what);
}

/// What each node is, its own word or the nearest above it.
Result<std::vector<std::string>> roles_of(const Model& model) {
    std::vector<std::string> roles(model.nodes.size());
    for (const int number : model.order) {
        const auto i = static_cast<std::size_t>(number);
        const Node& node = model.nodes[i];
        roles[i] = node.proxy.empty() && node.parent >= 0 ? roles[static_cast<std::size_t>(node.parent)] : node.proxy;
        if (!node.proxy.empty() && node.proxy != walkable_role &&
            std::ranges::find(shape_roles, node.proxy) == shape_roles.end())
            return wrong(node, ErrorKind::invalid_argument,
                         "'" + node.proxy + "' is none of ground, obstacle, wall, catcher, holdout and walkable");
    }
    return roles;
}

Result<void> add_walkable(const Model& model, const PosedModel& pose, std::size_t node,
                          std::vector<std::vector<glm::dvec2>>& to) {
    // A sliver of a walk, of upright faces or of a modeller's rounding.
    constexpr double least_m2 = 1e-6;
    for (const Primitive& primitive : model.meshes[static_cast<std::size_t>(model.nodes[node].mesh)].primitives) {
        if (primitive.topology != Topology::triangles) continue;
        for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
            std::vector<glm::dvec2> corners;
            for (std::size_t k = 0; k < 3; ++k)
                corners.emplace_back(pose.model_from_node[node] *
                                     glm::dvec4(primitive.positions[primitive.indices[i + k]], 1.0));
            const glm::dvec2 a = corners[1] - corners[0], b = corners[2] - corners[0];
            if (std::abs(a.x * b.y - a.y * b.x) < least_m2) continue;
            if (to.size() == most_walkable_triangles)
                return wrong(model.nodes[node], ErrorKind::resource_exhausted,
                             "more than " + std::to_string(most_walkable_triangles) +
                                 " walkable triangles; a flat outline is enough");
            to.push_back(std::move(corners));
        }
    }
    return {};
}

/// The model with the meshes of those nodes alone; null: none has one.
template <typename IsWanted>
ModelRef only(const Model& model, const std::vector<std::string>& roles, const IsWanted& is_wanted) {
    Model made = model;
    bool has_any = false;
    std::map<int, int> unlit;  // meshes, by those they are of
    for (std::size_t i = 0; i < made.nodes.size(); ++i) {
        Node& node = made.nodes[i];
        if (node.mesh < 0) continue;
        if (!is_wanted(roles[i])) {
            node.mesh = node.skin = -1;
            continue;
        }
        has_any = true;
        if (roles[i] != holdout_role) continue;
        // What has no light has none to lose.
        const auto [copy, is_new] = unlit.emplace(node.mesh, static_cast<int>(made.meshes.size()));
        if (!is_new) {
            node.mesh = copy->second;
            continue;
        }
        Mesh mesh = made.meshes[static_cast<std::size_t>(node.mesh)];
        for (Primitive& primitive : mesh.primitives) {
            Material material =
                primitive.material < 0 ? Material{} : made.materials[static_cast<std::size_t>(primitive.material)];
            material.unlit = true;
            primitive.material = static_cast<int>(made.materials.size());
            made.materials.push_back(std::move(material));
        }
        node.mesh = copy->second;
        made.meshes.push_back(std::move(mesh));
    }
    return has_any ? std::make_shared<const Model>(std::move(made)) : nullptr;
}

}  // namespace

Result<ModelProxies> proxies_of_model(const ModelRef& model) {
    const auto roles = roles_of(*model);
    if (!roles) return std::unexpected(roles.error());
    if (std::ranges::all_of(*roles, &std::string::empty)) return ModelProxies{model, {}, {}};
    ModelProxies made;
    PosedModel pose;
    pose_model(*model, {}, pose);
    for (const int number : model->order) {
        const auto i = static_cast<std::size_t>(number);
        if (model->nodes[i].mesh < 0 || (*roles)[i] != walkable_role) continue;
        if (auto added = add_walkable(*model, pose, i, made.walkable); !added) return std::unexpected(added.error());
    }
    made.shapes = only(*model, *roles, [](const std::string& role) {
        return !role.empty() && role != walkable_role && role != catcher_role;
    });
    made.catchers = only(*model, *roles, [](const std::string& role) { return role == catcher_role; });
    return made;
}

}  // namespace camrig::world
