#include <filesystem>
#include <fstream>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_list.h"
#include "core/world/daylit.h"
#include "core/world/photometric.h"
#include "core/world/scene_reader.h"
#include "tests/unit/world/world_fixture.h"

// Light in candela, lux and candela per square metre, and fog.
namespace camrig::world {
namespace {

using namespace world_test;
using nlohmann::json;

/// A lamp that is a model: it emits, and has a light.
ModelRef lamp_model() {
    auto model = std::make_shared<Model>();
    Material glass;
    glass.emissive = {300.0f, 150.0f, 0.0f};
    model->materials = {glass};
    model->lights.push_back({.name = "bulb", .type = LightType::point, .intensity = 60.0f});
    Node node;
    node.light = 0;
    model->nodes = {node};
    model->order = {0};
    return model;
}

Result<Scene> read(json environment, bool is_photometric, json lights = json::array(), json events = json::array()) {
    const json scene{{"camrig_scene", 1},
                     {"name", "lamps"},
                     {"environment", std::move(environment)},
                     {"models", {{"lamp", {{"file", "lamp.glb"}, {"photometric", is_photometric}}}}},
                     {"objects", {{{"name", "lamp"}, {"model", "lamp"}}}},
                     {"lights", std::move(lights)},
                     {"events", std::move(events)}};
    return read_scene(scene, "/nowhere", [](const std::filesystem::path&) -> Result<ModelRef> { return lamp_model(); });
}

TEST(Units, CandelaAndLuxAreSharesOfTheLuxThatAreWhite) {
    const json lights{{{"name", "bulb"}, {"type", "point"}, {"position", {0, 0, 3}}, {"candela", 100}},
                      {{"name", "moon"}, {"type", "directional"}, {"direction", {0, 0, -1}}, {"lux", 0.25}},
                      {{"name", "old"}, {"type", "point"}, {"position", {0, 0, 3}}, {"intensity", 7}}};
    const auto scene = read({{"lux", 500}}, false, lights);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_FLOAT_EQ(scene->lights[0].intensity, 0.2f) << "100 lx at 1 m, of 500 that are white";
    EXPECT_FLOAT_EQ(scene->lights[1].intensity, 0.0005f);
    EXPECT_EQ(scene->lights[2].intensity, 7.0f);
    const auto by_day = read({{"daylight", {{"azimuth_deg", 90}, {"elevation_deg", 30}}}}, false, lights);
    ASSERT_TRUE(by_day) << by_day.error().message;
    const auto bulb = std::ranges::find(by_day->lights, "bulb", &Light::name);
    EXPECT_FLOAT_EQ(bulb->intensity, static_cast<float>(100 / daylight_lux));
}

TEST(Units, PhotometricModelsHaveTheLightOfTheirFileInTheUnitsOfGltf) {
    const auto plain = read({{"lux", 500}}, false);
    ASSERT_TRUE(plain) << plain.error().message;
    EXPECT_EQ(plain->models.at("lamp").model->materials[0].emissive, glm::vec3(300.0f, 150.0f, 0.0f)) << "as ever";
    EXPECT_FLOAT_EQ(plain->lights[0].intensity, static_cast<float>(60 / std::numbers::pi)) << "as ever";

    const auto scene = read({{"lux", 500}}, true);
    ASSERT_TRUE(scene) << scene.error().message;
    // White in 500 lx has 500 / pi cd/m2 and is 1.
    EXPECT_FLOAT_EQ(scene->models.at("lamp").model->materials[0].emissive.r,
                    static_cast<float>(300 * std::numbers::pi / 500));
    EXPECT_FLOAT_EQ(scene->models.at("lamp").model->materials[0].emissive.g,
                    static_cast<float>(150 * std::numbers::pi / 500));
    EXPECT_FLOAT_EQ(scene->lights[0].intensity, 60.0f / 500.0f);
}

TEST(Units, EventsSwitchTheLightsOfModels) {
    const auto with = [](json action) {
        action["action"] = "light";
        return read({{"lux", 500}}, true, {{{"name", "old"}, {"type", "point"}, {"position", {0, 0, 3}}}},
                    {{{"name", "dusk"}, {"when", {{"at_s", 1}}}, {"do", {std::move(action)}}}});
    };
    auto scene = with({{"light", "lamp.bulb"}, {"candela", 250}});
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_EQ(scene->lights.size(), 2u);
    EXPECT_FLOAT_EQ(scene->lights[1].intensity, 60.0f / 500.0f);
    auto world = World::create(std::make_shared<Scene>(std::move(*scene)), 1).value();
    world->advance_to(ns_per_s);
    EXPECT_FLOAT_EQ(world->snapshot(ns_per_s)->statics->lights[1].intensity, 0.5f);
    EXPECT_THAT(with({{"light", "lamp.bulb"}, {"lux", 1}}).error().message,
                testing::HasSubstr("events[0].do[0].lux: 'lamp.bulb' is a lamp, give candela"));
    EXPECT_THAT(with({{"light", "lamp.tube"}, {"intensity", 1}}).error().message,
                testing::HasSubstr("events[0].do[0].light: no light 'lamp.tube'; known: lamp.bulb, old"));
}

TEST(Units, LightsOfModelsThatCannotBeReadAreNoErrorOfEvents) {
    const json scene{{"camrig_scene", 1},
                     {"name", "lamps"},
                     {"models", {{"lamp", {{"file", "lamp.glb"}}}}},
                     {"objects", {{{"name", "lamp 1.5"}, {"model", "lamp"}}}},
                     {"events",
                      {{{"name", "dusk"},
                        {"when", {{"at_s", 1}}},
                        {"do", {{{"action", "light"}, {"light", "lamp 1.5.bulb"}, {"intensity", 1}}}}}}}};
    ErrorList list;
    EXPECT_FALSE(read_scene(scene, "/nowhere", [](const std::filesystem::path&) -> Result<ModelRef> {
        return error(ErrorKind::not_found, "no such file");
    }));
    ASSERT_EQ(list.all().size(), 1u);
    EXPECT_EQ(list.all()[0].path, "models.lamp.file");
}

TEST(Units, NeedAUnit) {
    const auto scene = read(json::object(), true,
                            {{{"name", "moon"}, {"type", "directional"}, {"direction", {0, 0, -1}}, {"lux", 1}}});
    ASSERT_FALSE(scene);
    EXPECT_THAT(scene.error().message, testing::HasSubstr("lights[0].lux: needs environment.lux"));
}

TEST(Fog, ComesAndGoesByEventsAndAtOnce) {
    auto scene = empty_scene();
    scene->events = {event(
        R"({"name": "mist", "when": {"at_s": 1}, "do": [{"action": "environment", "fog": {"visibility_m": 80}}]})")};
    auto world = World::create(scene, 1).value();
    world->advance_to(0);
    EXPECT_EQ(world->snapshot(0)->statics->environment.fog, FogSpec{});
    const StateHash clear = world->state_hash();
    world->advance_to(2 * ns_per_s);
    EXPECT_EQ(world->snapshot(2 * ns_per_s)->statics->environment.fog.visibility_m, 80.0);
    EXPECT_NEAR(std::exp(-80.0 * extinction_per_m({.visibility_m = 80.0})), 0.02, 1e-4);
    const StateHash before = world->state_hash();
    EXPECT_NE(before.value, clear.value);
    ASSERT_TRUE(world->act(event(R"({"name": "x", "when": {"at_s": 99}, "do": [{"action": "environment",
                                     "fog": {"visibility_m": 0}}]})")
                               .actions));
    EXPECT_EQ(world->snapshot(2 * ns_per_s)->statics->environment.fog, FogSpec{});
    EXPECT_NE(world->state_hash().value, before.value);
    EXPECT_EQ(extinction_per_m({}), 0.0);
}

TEST(ExposureOfACamera, IsOfThoseWithoutSensorAndBackdrop) {
    CameraPatch patch;
    patch.change([](CameraSpec& spec) { spec.exposure_ev = 1.0; });
    EXPECT_TRUE(patch_camera_spec({}, patch));
    patch.change([](CameraSpec& spec) { spec.sensor.emplace(); });
    const auto refused = patch_camera_spec({}, patch);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, testing::HasSubstr("exposure_ev: a camera with a sensor is exposed by"));
}

}  // namespace
}  // namespace camrig::world
