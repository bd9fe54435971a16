#include "tests/unit/bake/scenes.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/world/baked/shared_exponent.h"
#include "core/world/model_lights.h"
#include "core/world/posed_model.h"
#include "core/world/world.h"
#include "tests/temporary_folder.h"

namespace camrig::bake {

world::SceneRef scene_of(const std::vector<TestBox>& boxes, const std::string& rest) {
    std::string models, objects;
    for (const TestBox& box : boxes) {
        const char* const comma = models.empty() ? "" : ", ";
        models += fmt::format(R"({}"{}": {{"shape": "box", "size": [{}, {}, {}], "color": [{}, {}, {}]}})", comma,
                              box.name, box.size.x, box.size.y, box.size.z, box.color, box.color, box.color);
        objects += fmt::format(R"({}{{"name": "{}", "model": "{}", "position": [{}, {}, {}]}})", comma, box.name,
                               box.name, box.position.x, box.position.y, box.position.z);
    }
    const TemporaryFolder folder;
    const auto file = folder / "scene.json";
    std::ofstream(file) << fmt::format(R"({{"camrig_scene": 1, "name": "test", "models": {{{}}}, "objects": [{}]{}}})",
                                       models, objects, rest);
    world::SceneOptions without;
    without.baked_light = false;
    auto scene = world::load_scene(file, without);
    EXPECT_TRUE(scene.has_value()) << (scene ? "" : scene.error().message);
    return scene.value_or(nullptr);
}

std::vector<TestBox> room(const glm::dvec3& size, double color) {
    constexpr double wall = 0.5;
    const double x = 0.5 * (size.x + wall), y = 0.5 * (size.y + wall);
    return {{"floor", {0, 0, -wall}, {size.x + 2 * wall, size.y + 2 * wall, wall}, color},
            {"roof", {0, 0, size.z}, {size.x + 2 * wall, size.y + 2 * wall, wall}, color},
            {"east", {x, 0, 0}, {wall, size.y + 2 * wall, size.z}, color},
            {"west", {-x, 0, 0}, {wall, size.y + 2 * wall, size.z}, color},
            {"north", {0, y, 0}, {size.x, wall, size.z}, color},
            {"south", {0, -y, 0}, {size.x, wall, size.z}, color}};
}

world::BakedLight baked(const world::SceneRef& scene, BakeOptions options) {
    auto light = bake(scene, options);
    EXPECT_TRUE(light.has_value()) << (light ? "" : light.error().message);
    return std::move(light).value_or(world::BakedLight{});
}

glm::vec3 light_at(const world::SceneRef& scene, const world::BakedLight& light, std::size_t layer,
                   const std::string& object, const glm::dvec3& place, const glm::dvec3& normal) {
    world::Scene cut(*scene);
    world::use_baked_light(cut, std::make_shared<const world::BakedLight>(light));
    const auto spec = std::ranges::find(cut.objects, object, &world::ObjectSpec::name);
    const auto of = std::ranges::find(light.objects, object, &world::BakedObject::name);
    const world::Model& model = *cut.models.at(spec->model).model;
    world::PosedModel pose;
    pose_model(model, {}, pose);
    for (const world::BakedSurface& surface : of->surfaces) {
        const glm::dmat4 from = world::world_from_model(spec->position, spec->orientation, spec->scale) *
                                pose.model_from_node[static_cast<std::size_t>(surface.node)];
        const world::Primitive& primitive = model.meshes[0].primitives[surface.primitive];
        for (std::size_t i = 0; i < primitive.indices.size(); i += 3) {
            std::array<glm::dvec3, 3> p;
            for (std::size_t k = 0; k < 3; ++k)
                p[k] = glm::dvec3(from * glm::dvec4(primitive.positions[primitive.indices[i + k]], 1.0));
            const glm::dvec3 across = glm::cross(p[1] - p[0], p[2] - p[0]);
            if (glm::dot(glm::normalize(across), normal) < 0.9) continue;
            const auto share = [&](std::size_t a, std::size_t b) {
                return glm::dot(glm::cross(p[b] - p[a], place - p[a]), across) / glm::dot(across, across);
            };
            const double third = share(0, 1), first = share(1, 2), second = share(2, 0);
            if (std::min({first, second, third}) < -1e-9) continue;
            const glm::dvec2 at = first * glm::dvec2(primitive.light_coordinates[primitive.indices[i]]) +
                                  second * glm::dvec2(primitive.light_coordinates[primitive.indices[i + 1]]) +
                                  third * glm::dvec2(primitive.light_coordinates[primitive.indices[i + 2]]) +
                                  glm::dvec2(surface.x, surface.y) - 0.5;
            const glm::dvec2 low = glm::floor(at), part = at - low;
            const auto texel = [&](int dx, int dy) {
                const auto x = static_cast<std::size_t>(low.x) + static_cast<std::size_t>(dx);
                const auto y = static_cast<std::size_t>(low.y) + static_cast<std::size_t>(dy);
                return glm::dvec3(world::unpacked_light(
                    light.layers[layer].texels[y * static_cast<std::size_t>(light.size.width) + x]));
            };
            return glm::vec3(glm::mix(glm::mix(texel(0, 0), texel(1, 0), part.x),
                                      glm::mix(texel(0, 1), texel(1, 1), part.x), part.y));
        }
    }
    ADD_FAILURE() << object << " has no place there";
    return {};
}

std::size_t layer_of(const world::BakedLight& light, world::LightSource source) {
    const auto at = std::ranges::find(light.layers, source, &world::LightLayer::source);
    EXPECT_NE(at, light.layers.end());
    return static_cast<std::size_t>(at - light.layers.begin());
}

}  // namespace camrig::bake
