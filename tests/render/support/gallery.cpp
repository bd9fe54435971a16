#include "tests/render/support/gallery.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace camrig::render {

world::Image patterned(ImageSize size) {
    world::Image image{.size = size, .rgba = {}};
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
            const int dark = (x * 8 / size.width + y * 8 / size.height) % 2 * 90;
            for (const int value : {255 - dark - 100 * x / size.width, 60 + 100 * y / size.height, 160 - dark,
                                    255 * (x * 4 % size.width) / size.width})
                image.rgba.push_back(static_cast<std::uint8_t>(value));
        }
    }
    return image;
}

world::Primitive ball(float radius, int rings) {
    world::Primitive p;
    for (int i = 0; i <= rings; ++i) {
        for (int j = 0; j <= 2 * rings; ++j) {
            const float down = std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(rings);
            const float around = std::numbers::pi_v<float> * static_cast<float>(j) / static_cast<float>(rings);
            const glm::vec3 n(std::sin(down) * std::cos(around), std::sin(down) * std::sin(around), std::cos(down));
            p.positions.push_back(radius * n);
            p.normals.push_back(n);
            p.texcoords[0].emplace_back(around, down);
            p.colors.emplace_back(0.5f + 0.5f * n, 1.0f);
        }
    }
    const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (2 * rings + 1) + j); };
    for (int i = 0; i < rings; ++i) {
        for (int j = 0; j < 2 * rings; ++j)
            p.indices.insert(p.indices.end(),
                             {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    return p;
}

TestWorld gallery() {
    const auto textured = [](world::Primitive primitive, world::Material material, glm::vec2 scale) {
        material.base_color_texture = {.texture = 0, .offset = {0.1f, 0.2f}, .scale = scale, .rotation = 0.3f};
        auto model = model_of(std::move(primitive), std::move(material));
        model->images.push_back(patterned({64, 64}));
        model->textures.push_back({.image = 0, .sampler = {}});
        return model;
    };
    const auto without_colors = [](world::Primitive primitive) {
        primitive.colors.clear();
        return primitive;
    };
    const world::Material white = colored(glm::vec3(0.9f));
    world::Material masked = white, glass = colored({0.3f, 0.5f, 0.9f}), thin = colored({0.8f, 0.3f, 0.2f});
    masked.alpha_mode = world::AlphaMode::mask;
    glass.alpha_mode = world::AlphaMode::blend;
    glass.base_color.a = 0.4f;
    thin.double_sided = true;
    world::Material lamp = colored(glm::vec3(0.2f));
    lamp.emissive = {0.5f, 0.3f, 0.1f};
    lamp.emissive_texture.texture = 0;
    lamp.occlusion_texture.texture = 0;
    lamp.occlusion_strength = 0.7f;

    TestWorld world;
    world.environment = {.background = {0.3f, 0.5f, 0.8f},
                         .ambient_sky = {0.2f, 0.25f, 0.3f},
                         .ambient_ground = {0.15f, 0.1f, 0.05f},
                         .exposure = 0.9f};
    world.lights = {
        light_of(world::LightType::directional, 0.5f, {}, glm::normalize(glm::dvec3(1.0, 0.4, -0.7))),
        light_of(world::LightType::point, 3.0f, {3.5, 1.0, 1.0}),
        light_of(world::LightType::spot, 9.0f, {2.5, -1.5, 2.0}, glm::normalize(glm::dvec3(0.6, 0.2, -0.8)))};
    world.lights[1].range = 4.0f;
    world.lights[2].inner_cone_rad = 0.2f;
    std::uint32_t id = 1;
    const auto put = [&](std::vector<world::Instance>& list, world::ModelRef model,
                         glm::dvec3 position) -> world::Instance& {
        return list.emplace_back(instance_of(std::move(model), position, id++));
    };
    auto& still = world.objects;
    // Not larger: that far from their beginning, floats hold texture coordinates to hundredths of a texel only.
    put(still, textured(rectangle({0, 0, -1}, {400, 0, 0}, {0, 400, 0}), white, {400.0f, 400.0f}), {});
    put(still, model_of(ball(0.5f, 12), white), {4, 1.6, -0.5});
    put(still, textured(without_colors(ball(0.6f, 16)), lamp, {2.0f, 1.0f}), {4.5, 0.3, -0.3});
    put(still, textured(rectangle({0, 0, 0}, {0.2f, -0.6f, 0}, {0, 0, 0.6f}), masked, {2.0f, 2.0f}), {3.5, -0.9, 0.2});
    put(still, model_of(rectangle({0, 0, 0}, {0.1f, 0.5f, 0}, {0, 0, 0.5f}), thin), {5, -1.9, 0.3});
    put(still, model_of(ball(0.3f, 6), colored(glm::vec3(0.8f), true)), {3, 0.9, 0.7});
    put(still, textured(box({0.3f, 0.4f, 0.7f}), white, {1.0f, 1.0f}), {7, 2.5, -0.3});
    put(still, model_of(box({0.05f, 0.5f, 0.5f}), glass), {3, 0.2, 0.1});
    put(world.movers, textured(box({0.3f, 0.3f, 0.4f}), white, {1.0f, 1.0f}), {4, -0.5, -0.6}).scale = -1.0;
    put(world.movers, model_of(without_colors(ball(0.3f, 10)), glass), {2.5, -0.7, -0.2});
    return world;
}

world::SnapshotRef with_moved_objects(const world::SnapshotRef& from, const glm::dvec3& by) {
    auto statics = std::make_shared<world::StaticSet>(*from->statics);
    for (world::Instance& object : statics->objects) object.position += by;
    auto moved = std::make_shared<world::Snapshot>(*from);
    moved->statics = statics;
    return moved;
}

Film::Film(const std::string& scene, bool baked_light) {
    auto loaded = world::load_scene("scenes/" + scene + ".json", {.baked_light = baked_light});
    if (!loaded) throw std::runtime_error(loaded.error().message);
    auto world = world::World::create(*loaded, 1);
    if (!world) throw std::runtime_error(world.error().message);
    world_ = std::move(*world);
}

world::SnapshotRef Film::at(TimeNs world_ns) {
    world_->advance_to(world_ns);
    return world_->snapshot(world_ns);
}

std::string Film::camera(std::size_t index) const {
    const auto& cameras = world_->scene().cameras;
    return cameras.at(index % cameras.size()).name;
}

View Film::view(const std::string& camera, ImageSize size, std::uint32_t number) const {
    for (const world::CameraSpec& given : world_->scene().cameras) {
        if (given.name != camera) continue;
        View view = TestCamera{}.view(number);
        auto spec = std::make_shared<world::CameraSpec>(given);
        spec->size = size;
        spec->intrinsics = camera::intrinsics_from_vfov(size, vfov_rad(given.size, given.intrinsics)).value();
        view.spec = spec;
        view.pose = given.pose;
        return view;
    }
    throw std::runtime_error("the scene has no camera '" + camera + "'");
}

}  // namespace camrig::render
