#include "tests/render/support/test_models.h"

#include <numeric>

namespace camrig::render {

std::shared_ptr<world::Model> model_of(world::Primitive primitive, world::Material material) {
    auto model = std::make_shared<world::Model>();
    world::Node node;
    node.mesh = 0;
    // Inverse of world_from_gltf (x, y, z) -> (x, -z, y).
    node.has_matrix = true;
    node.matrix =
        glm::dmat4(glm::dvec4(1, 0, 0, 0), glm::dvec4(0, 0, -1, 0), glm::dvec4(0, 1, 0, 0), glm::dvec4(0, 0, 0, 1));
    model->nodes.push_back(node);
    model->order = {0};
    primitive.material = 0;
    primitive.bounds = {primitive.positions.front(), primitive.positions.front()};
    for (const glm::vec3& p : primitive.positions) {
        primitive.bounds.min = glm::min(primitive.bounds.min, p);
        primitive.bounds.max = glm::max(primitive.bounds.max, p);
    }
    model->meshes.push_back({.name = "mesh", .primitives = {std::move(primitive)}, .weights = {}});
    model->materials.push_back(std::move(material));
    return model;
}

world::Primitive rectangle(glm::vec3 centre, glm::vec3 u, glm::vec3 v) {
    world::Primitive p;
    p.positions = {centre - u - v, centre + u - v, centre + u + v, centre - u + v};
    p.normals.assign(4, glm::normalize(glm::cross(u, v)));
    p.texcoords[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    p.indices = {0, 1, 2, 0, 2, 3};
    return p;
}

world::Primitive triangles(std::vector<glm::vec3> corners) {
    world::Primitive p;
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
        const glm::vec3 normal = glm::cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]);
        p.normals.insert(p.normals.end(), 3, glm::length(normal) > 0 ? glm::normalize(normal) : glm::vec3(0, 0, 1));
    }
    p.positions = std::move(corners);
    p.indices.resize(p.positions.size());
    std::iota(p.indices.begin(), p.indices.end(), 0u);
    return p;
}

world::Primitive box(glm::vec3 half) {
    world::Primitive p;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float sign : {-1.0f, 1.0f}) {
            glm::vec3 n(0.0f), u(0.0f), v(0.0f);
            n[axis] = sign * half[axis];
            u[(axis + 1) % 3] = half[(axis + 1) % 3];
            v[(axis + 2) % 3] = sign * half[(axis + 2) % 3];
            const world::Primitive face = rectangle(n, u, v);
            const auto base = static_cast<std::uint32_t>(p.positions.size());
            p.positions.insert(p.positions.end(), face.positions.begin(), face.positions.end());
            p.normals.insert(p.normals.end(), face.normals.begin(), face.normals.end());
            p.texcoords[0].insert(p.texcoords[0].end(), face.texcoords[0].begin(), face.texcoords[0].end());
            for (const auto index : face.indices) p.indices.push_back(base + index);
        }
    }
    return p;
}

world::Material colored(glm::vec3 linear, bool unlit) {
    world::Material material;
    material.base_color = glm::vec4(linear, 1.0f);
    material.metallic = 0.0f;
    material.unlit = unlit;
    return material;
}

world::Instance instance_of(world::ModelRef model, glm::dvec3 position, std::uint32_t id) {
    auto info = std::make_shared<world::ObjectInfo>();
    info->id = ObjectId{id};
    info->name = "object" + std::to_string(id);
    info->object_class = "object";
    info->model = std::move(model);
    world::Instance instance;
    instance.info = std::move(info);
    instance.position = position;
    return instance;
}

world::Light light_of(world::LightType type, float intensity, glm::dvec3 position, glm::dvec3 direction) {
    world::Light light;
    light.type = type;
    light.intensity = intensity;
    light.position = position;
    light.direction = direction;
    return light;
}

world::SnapshotRef TestWorld::snapshot(TimeNs world_ns) const {
    auto statics = std::make_shared<world::StaticSet>();
    statics->objects = objects;
    statics->lights = lights;
    statics->environment = environment;
    auto result = std::make_shared<world::Snapshot>();
    result->world_ns = world_ns;
    result->statics = std::move(statics);
    result->movers = movers;
    return result;
}

}  // namespace camrig::render
