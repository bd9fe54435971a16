#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/json_reader.h"
#include "core/world/gltf_loader.h"
#include "core/world/model_scene.h"
#include "core/world/scene_reader.h"
#include "tests/unit/world/glb_builder.h"

namespace camrig {
namespace {

using nlohmann::json;
using testing::HasSubstr;

ModelRef box_model() {
    GlbBuilder glb;
    const int times = glb.floats({0, 1}, "SCALAR"), values = glb.floats({0, 0, 0, 1, 0, 0}, "VEC3");
    glb.mesh({0, 0, 0, 1, 0, 0, 0, 1, 0});
    glb.json["animations"] = {{{"name", "walk"},
                               {"extras", {{"ground_speed_m_s", 1.0}}},
                               {"samplers", {{{"input", times}, {"output", values}}}},
                               {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
    return load_model(glb.build(), {}, "box").value();
}

json full_scene() {
    return json::parse(R"({
      "camrig_scene": 1, "name": "test", "description": "d", "seed": 4, "step_ns": 20000000,
      "environment": {"background": [0, 0.5, 1], "ambient": {"sky": [1, 1, 1], "ground": [0, 0, 0]}, "exposure": 2},
      "models": {"box": {"file": "box.glb"}, "man": {"file": "box.glb", "front": "+x"}},
      "objects": [{"name": "a", "model": "box", "class": "crate", "position": [1, 2, 3], "yaw_deg": 90, "scale": 2},
                  {"name": "b", "model": "box", "orientation": [0, 0, 0, 1], "clip": "walk"}],
      "lights": [{"name": "sun", "type": "directional", "color": [1, 1, 1], "intensity": 2, "direction": [0, 0, -2]},
                 {"name": "lamp", "type": "point", "intensity": 20, "position": [0, 0, 3], "range": 8},
                 {"name": "spot", "type": "spot", "position": [0, 0, 3], "direction": [0, 0, -1],
                  "inner_cone_deg": 10, "outer_cone_deg": 20}],
      "routes": {"loop": {"points": [[0, 0], [10, 0], [10, 10, 0.5]], "closed": true},
                 "line": {"points": [[0, 0], [10, 0]]}},
      "actors": [{"name": "anna", "model": "man", "class": "person", "scale": 1,
                  "behaviour": {"type": "route", "route": "loop", "speed": 1.3, "start_m": 4, "mode": "loop", "clip": "walk"}},
                 {"name": "tom", "model": "man", "class": "person", "position": [1, 1, 0], "yaw_deg": 90,
                  "behaviour": {"type": "stand", "clip": "walk"}}],
      "places": {"lobby": {"description": "x", "pose": {"position": [2, 3, 2.8], "look_at": [12, 9, 1]}, "vfov_deg": 50}},
      "cameras": [{"name": "lobby", "place": "lobby", "size": [640, 480], "fps": 10}]})");
}

Result<Scene> read(const json& document) {
    return read_scene(document, "/nowhere",
                      [](const std::filesystem::path&) -> Result<ModelRef> { return box_model(); });
}

TEST(SceneReader, ReadsEveryPartOfTheFormat) {
    const auto scene = read(full_scene());
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->step_ns, 20 * ns_per_ms);
    EXPECT_EQ(scene->environment.exposure, 2.0f);
    EXPECT_EQ(scene->objects.size(), 2u);
    EXPECT_EQ(scene->objects[0].object_class, "crate");
    EXPECT_EQ(scene->lights[0].direction, glm::dvec3(0, 0, -1));
    EXPECT_EQ(scene->lights[2].type, LightType::spot);
    EXPECT_EQ(scene->routes.at("loop").points[1], glm::dvec3(10, 0, 0));
    EXPECT_EQ(std::get<RouteBehaviour>(scene->actors[0].behaviour).start_m, 4.0);
    ASSERT_EQ(scene->cameras.size(), 1u);
    EXPECT_EQ(scene->cameras[0].pose, scene->places.at("lobby").pose);
    EXPECT_NEAR(vfov_rad(scene->cameras[0].size, scene->cameras[0].intrinsics), glm::radians(50.0), 1e-12);
}

TEST(SceneReader, WrongScenesAreErrorsWithTheJsonPath) {
    const auto patched = [](const char* pointer, json value) {
        json scene = full_scene();
        scene[json::json_pointer(pointer)] = std::move(value);
        const auto result = read(scene);
        return result ? "loaded" : result.error().message;
    };
    EXPECT_THAT(patched("/camrig_scene", 2), HasSubstr("camrig_scene: version 2"));
    EXPECT_THAT(patched("/colour", 2), HasSubstr("colour: unknown key"));
    EXPECT_THAT(patched("/environment/fog", 2), HasSubstr("environment.fog: unknown key"));
    EXPECT_THAT(patched("/environment/ambient/sky", {1, 2}), HasSubstr("environment.ambient.sky"));
    EXPECT_THAT(patched("/step_ns", 1), HasSubstr("step_ns"));
    EXPECT_THAT(patched("/models/box/file", "../box.glb"), HasSubstr("models.box.file: must be a path below"));
    EXPECT_THAT(patched("/models/box/file", "/box.glb"), HasSubstr("models.box.file"));
    EXPECT_THAT(patched("/models/man/front", "+y"), HasSubstr("models.man.front"));
    EXPECT_THAT(patched("/objects/0/model", "bax"), HasSubstr("objects[0].model: no model 'bax'; known: box, man"));
    EXPECT_THAT(patched("/objects/1/name", "a"), HasSubstr("objects[1].name: 'a' is taken"));
    EXPECT_THAT(patched("/objects/1/clip", "run"),
                HasSubstr("objects[1].clip: the model has no clip 'run'; it has: walk"));
    EXPECT_THAT(patched("/objects/1/yaw_deg", 3), HasSubstr("only one of yaw_deg and orientation"));
    EXPECT_THAT(patched("/objects/0/scale", 0), HasSubstr("objects[0].scale"));
    EXPECT_THAT(patched("/lights/0/type", "neon"), HasSubstr("lights[0].type"));
    EXPECT_THAT(patched("/lights/0/direction", {0, 0, 0}), HasSubstr("lights[0].direction: has no length"));
    EXPECT_THAT(patched("/lights/1/inner_cone_deg", 3), HasSubstr("lights[1].inner_cone_deg: unknown key"));
    EXPECT_THAT(patched("/routes/loop/points", {{0, 0}}), HasSubstr("routes.loop"));
    EXPECT_THAT(patched("/routes/loop/points/1", {0, "x"}), HasSubstr("routes.loop.points[1]"));
    EXPECT_THAT(patched("/actors/0/behaviour/route", "lop"),
                HasSubstr("actors[0].behaviour.route: no route 'lop'; known: line, loop"));
    EXPECT_THAT(patched("/actors/0/behaviour/route", "line"), HasSubstr("actors[0].behaviour.mode"));
    EXPECT_THAT(patched("/actors/0/behaviour/clip", "run"), HasSubstr("actors[0].behaviour.clip"));
    EXPECT_THAT(patched("/actors/0/position", {0, 0, 0}), HasSubstr("its route places this actor"));
    EXPECT_THAT(patched("/actors/1/behaviour/type", "dance"), HasSubstr("actors[1].behaviour.type: 'dance'"));
    EXPECT_THAT(patched("/places/lobby/pose/position", {0, 0}), HasSubstr("places.lobby.pose.position"));
    EXPECT_THAT(patched("/cameras/0/place", "loby"), HasSubstr("cameras[0].place: no place 'loby'; known: lobby"));
    EXPECT_THAT(patched("/cameras/0/name", "Lobby!"), HasSubstr("cameras[0].name"));
    EXPECT_THAT(patched("/cameras/0/size", {1, 1}), HasSubstr("cameras[0].size: 1x1"));
}

TEST(LoadScene, ErrorsNameTheFile) {
    const auto file = std::filesystem::path(testing::TempDir()) / "broken_scene.json";
    std::ofstream(file) << "{\"camrig_scene\": 1,";
    EXPECT_THAT(load_scene(file).error().message, HasSubstr("broken_scene.json: not JSON"));
    EXPECT_EQ(load_scene("/no/such/scene.json").error().kind, ErrorKind::not_found);
    EXPECT_THAT(load_scene("picture.png").error().message, HasSubstr("scenes are .json, .gltf or .glb"));
    EXPECT_THAT(load_scene("/no/such/model.glb").error().message, HasSubstr("/no/such/model.glb: no such file"));
    EXPECT_FALSE(load_scene(testing::TempDir()));
}

TEST(LoadScene, AModelThatIsMissingIsNamedWithItsJsonPath) {
    const auto file = std::filesystem::path(testing::TempDir()) / "missing_model.json";
    std::ofstream(file) << R"({"camrig_scene": 1, "name": "x", "models": {"m": {"file": "gone.glb"}}})";
    const auto message = load_scene(file).error().message;
    EXPECT_THAT(message, HasSubstr("models.m.file"));
    EXPECT_THAT(message, HasSubstr("gone.glb: no such file"));
}

TEST(SceneOfModel, FramesABareModelAndLoopsItsFirstClip) {
    const auto scene = scene_of_model(box_model());
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->objects[0].clip, "walk");
    ASSERT_EQ(scene->cameras.size(), 1u);
    EXPECT_EQ(scene->cameras[0].name, "main");
    EXPECT_EQ(scene->lights.size(), 1u);
}

TEST(SceneOfModel, TakesTheModelsCamerasAndLights) {
    GlbBuilder glb;
    glb.mesh({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const json camera = {{"type", "perspective"},
                         {"name", "Front Door"},
                         {"perspective", {{"yfov", 0.7}, {"znear", 0.2}, {"aspectRatio", 2.0}}}};
    glb.json["cameras"] = {camera};
    glb.json["extensionsUsed"] = {"KHR_lights_punctual"};
    glb.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 3.0}}};
    glb.json["nodes"].push_back({{"camera", 0}, {"translation", {0, 1, 5}}});
    glb.json["nodes"].push_back({{"camera", 0}});
    glb.json["nodes"].push_back(
        {{"name", "bulb"}, {"translation", {0, 2, 0}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    glb.json["scenes"] = {{{"nodes", {0, 1, 2, 3}}}};
    const auto model = load_model(glb.build(), {}, "test");
    ASSERT_TRUE(model) << model.error().message;
    const auto scene = scene_of_model(*model);
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_EQ(scene->cameras.size(), 2u);
    EXPECT_EQ(scene->cameras[0].name, "front_door");
    EXPECT_EQ(scene->cameras[1].name, "front_door_2");
    EXPECT_EQ(scene->cameras[0].size, (ImageSize{960, 480}));
    // It stands at glTF (0, 1, 5), looks along -z there: from y = -5 along +y here.
    const Pose& pose = scene->cameras[0].pose;
    EXPECT_EQ(pose.position, glm::dvec3(0, -5, 1));
    EXPECT_LT(glm::distance(pose.orientation * glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)), 1e-12);
    EXPECT_LT(glm::distance(pose.orientation * glm::dvec3(0, 0, 1), glm::dvec3(0, 0, 1)), 1e-12);
    ASSERT_EQ(scene->lights.size(), 1u);
    EXPECT_EQ(scene->lights[0].name, "model.bulb");
    EXPECT_EQ(scene->lights[0].position, glm::dvec3(0, 0, 2));
}

}  // namespace
}  // namespace camrig
