#include <algorithm>
#include <chrono>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/json_reader.h"
#include "core/world/gltf_loader.h"
#include "core/world/model_scene.h"
#include "core/world/scene_check.h"
#include "core/world/scene_reader.h"
#include "core/world/shape_model.h"
#include "tests/temporary_folder.h"
#include "tests/unit/world/glb_builder.h"

namespace camrig::world::scene_loader_test {
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

/// One scene that uses every key, with right and wrong edits of it; the schema's test reads them too.
const json& cases() {
    static const json loaded = [] {
        std::ifstream file("tests/unit/world/scene_cases.json");
        return json::parse(file);
    }();
    return loaded;
}

json edited(const json& edit) {
    json scene = cases().at("scene");
    const json::json_pointer place(edit.at("at").get<std::string>());
    json& parent = scene[place.parent_pointer()];
    if (edit.contains("value"))
        scene[place] = edit.at("value");
    else if (parent.is_array())
        parent.erase(std::stoul(place.back()));
    else
        parent.erase(place.back());
    return scene;
}

Result<Scene> read(const json& document) {
    return read_scene(document, "/nowhere",
                      [](const std::filesystem::path&) -> Result<ModelRef> { return box_model(); });
}

TEST(SceneReader, ReadsEveryPartOfTheFormat) {
    const auto scene = read(cases().at("scene"));
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->step_ns, 20 * ns_per_ms);
    EXPECT_EQ(scene->environment.exposure, 2.0f);
    EXPECT_EQ(scene->objects.size(), 3u);
    EXPECT_EQ(scene->areas.at("floor").obstacles[0].size(), 3u);
    EXPECT_EQ(scene->events.size(), 7u);
    EXPECT_EQ(std::get<SequenceBehaviour>(scene->actors[2].behaviour).steps.size(), 6u);
    EXPECT_EQ(scene->objects[0].object_class, "crate");
    EXPECT_EQ(scene->lights[0].direction, glm::dvec3(0, 0, -1));
    EXPECT_EQ(scene->lights[2].type, LightType::spot);
    EXPECT_EQ(scene->routes.at("loop").points[1], glm::dvec3(10, 0, 0));
    EXPECT_EQ(std::get<RouteBehaviour>(scene->actors[0].behaviour).start_m, 4.0);
    ASSERT_EQ(scene->cameras.size(), 3u);
    EXPECT_EQ(scene->cameras[0].pose, scene->places.at("lobby").pose);
    EXPECT_NEAR(vfov_rad(scene->cameras[0].size, scene->cameras[0].intrinsics), glm::radians(50.0), 1e-12);
}

TEST(SceneReader, RightEditsLoad) {
    for (const json& edit : cases().at("right")) {
        const auto scene = read(edited(edit));
        EXPECT_TRUE(scene) << edit.dump() << ": " << (scene ? "" : scene.error().message);
    }
}

TEST(SceneReader, WrongEditsAreErrorsWithTheJsonPath) {
    for (const json& edit : cases().at("wrong")) {
        const auto scene = read(edited(edit));
        EXPECT_THAT(scene ? "loaded" : scene.error().message, HasSubstr(edit.at("error").get<std::string>()))
            << edit.dump();
    }
}

TEST(SceneReader, TheExampleOfTheGuideLoads) {
    std::ifstream file("docs/scene-format.md");
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const auto begin = text.find("```json\n") + 8;
    const auto scene = read_scene(json::parse(text.substr(begin, text.find("```", begin) - begin)), "scenes",
                                  [](const std::filesystem::path& model) { return load_model(model); });
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_FALSE(scene->cameras.empty());
}

TEST(LoadScene, ErrorsNameTheFile) {
    const TemporaryFolder folder;
    const auto file = folder / "broken_scene.json";
    std::ofstream(file) << "{\"camrig_scene\": 1,";
    EXPECT_THAT(load_scene(file).error().message, HasSubstr("broken_scene.json: not JSON"));
    EXPECT_EQ(load_scene("/no/such/scene.json").error().kind, ErrorKind::not_found);
    EXPECT_THAT(load_scene("picture.png").error().message, HasSubstr("scenes are .json, .gltf or .glb"));
    EXPECT_THAT(load_scene("/no/such/model.glb").error().message, HasSubstr("/no/such/model.glb: no such file"));
    EXPECT_FALSE(load_scene(testing::TempDir()));
}

TEST(LoadScene, AWordIsAShippedSceneFromAnyFolder) {
    const auto before = std::filesystem::current_path();
    std::filesystem::current_path(testing::TempDir());
    const auto scene = load_scene("minimal");
    const auto unknown = load_scene("hal");
    std::filesystem::current_path(before);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ((*scene)->name, "minimal");
    EXPECT_EQ((*scene)->file.filename(), "minimal.json");
    EXPECT_EQ(unknown.error().kind, ErrorKind::not_found);
    EXPECT_THAT(unknown.error().message,
                HasSubstr("hall, minimal, street, street-evening, street-night, street-noon; else give"));
}

TEST(LoadScene, WhatIsNoModelIsSaidToBeNone) {
    const TemporaryFolder folder;
    const auto file = folder / "archive.glb";
    std::ofstream(file) << "PK\x03\x04 of a zip";
    EXPECT_THAT(load_scene(file).error().message,
                HasSubstr("archive.glb: is neither .glb nor .gltf: 13 bytes that begin with 'PK?? of '"));
}

TEST(LoadScene, AModelThatIsMissingIsNamedWithItsJsonPath) {
    const TemporaryFolder folder;
    const auto file = folder / "missing_model.json";
    std::ofstream(file) << R"({"camrig_scene": 1, "name": "x", "models": {"m": {"file": "gone.glb"}}})";
    const auto message = load_scene(file).error().message;
    EXPECT_THAT(message, HasSubstr("models.m.file"));
    EXPECT_THAT(message, HasSubstr("gone.glb: no such file"));
}

/// The texts of all errors of a scene, as `path: message`.
std::vector<std::string> errors_of(const json& document) {
    ErrorList list;
    const auto scene = read(document);
    EXPECT_EQ(scene.has_value(), list.all().empty());
    std::vector<std::string> texts;
    for (const PlacedError& each : list.all()) texts.push_back(each.path + ": " + each.message);
    return texts;
}

TEST(CheckScene, TellsEveryErrorAtOnceAndBlamesNobodyElse) {
    json scene = cases().at("scene");
    scene["colour"] = 1;
    scene["environment"]["exposure"] = -1;
    scene["models"]["man"]["front"] = "+y";  // actors of it are not to blame
    scene["objects"][0]["scale"] = "big";    // nor what refers to this object
    scene["objects"][0]["position"] = {1, 2};
    scene["lights"][0]["type"] = "sunny";
    scene["places"]["lobby"]["vfov_deg"] = 200;  // nor cameras at this place
    scene["cameras"][1]["fps"] = "0/1";
    scene["cameras"][1]["vfov"] = 60;
    scene["cameras"][0]["vfov_deg"] = 200;
    scene["actors"][3]["behaviour"]["route"] = "nowhere";
    scene["actors"][3]["behaviour"]["clip"] = "fly";
    const auto texts = errors_of(scene);
    using testing::StartsWith;
    EXPECT_THAT(
        texts,
        testing::UnorderedElementsAre(
            StartsWith("colour: unknown key"), StartsWith("environment.exposure: must be "),
            StartsWith("models.man.front: '+y' is none"), StartsWith("objects[0].scale: expected a number"),
            StartsWith("objects[0].position: expected an array of 3"), StartsWith("lights[0].type: 'sunny' is none"),
            StartsWith("places.lobby.vfov_deg: must be 0.01"), StartsWith("cameras[1].fps: '0/1' is not a frame rate"),
            StartsWith("cameras[1].vfov: unknown key"), StartsWith("cameras[0].vfov_deg: 200 deg is no field of view"),
            StartsWith("actors[3].behaviour.route: no route 'nowhere'"),
            StartsWith("actors[3].behaviour.clip: the model has no clip 'fly'")));
}

TEST(CheckScene, NameAndModelAreCheckedAlsoOfWhatIsWrongOtherwise) {
    json scene = cases().at("scene");
    scene["actors"].push_back(scene["actors"][1]);
    scene["actors"][1]["scale"] = "big";
    scene["actors"][1]["model"] = "none";
    const std::string again = "actors[" + std::to_string(scene["actors"].size() - 1) + "].name: 'tom' is taken";
    using testing::StartsWith;
    EXPECT_THAT(errors_of(scene),
                testing::UnorderedElementsAre(StartsWith("actors[1].model: no model 'none'"),
                                              StartsWith("actors[1].scale: expected a number"), StartsWith(again)));
}

TEST(CheckScene, BeginsWithTheErrorThatLoadingEndsWith) {
    for (const json& edit : cases().at("wrong")) {
        const json scene = edited(edit);
        const auto texts = errors_of(scene);
        ASSERT_FALSE(texts.empty()) << edit.dump();
        EXPECT_EQ(texts.front(), (texts.front().starts_with(": ") ? ": " : "") + read(scene).error().message)
            << edit.dump();
    }
    EXPECT_THAT(errors_of(cases().at("scene")), testing::IsEmpty());
}

TEST(CheckScene, KeepsABoundedNumberOfErrors) {
    json scene = cases().at("scene");
    for (int i = 0; i < 1000; ++i) scene["lights"].push_back({{"name", "x"}, {"type", 1}});
    scene["lights"].erase(scene["lights"].begin() + 200, scene["lights"].end());
    ErrorList list;
    EXPECT_FALSE(read(scene));
    EXPECT_EQ(list.all().size(), ErrorList::max_errors);
    EXPECT_GT(list.left_out(), 0u);
}

TEST(CheckScene, ReadsAFileWithoutAWorld) {
    const TemporaryFolder folder;
    const auto file = folder / "two_errors.json";
    std::ofstream(file) << R"({"camrig_scene": 1, "name": "", "models": {"m": {"file": "gone.glb"}}})";
    const SceneCheck check = check_scene(file);
    ASSERT_EQ(check.errors.size(), 2u);
    EXPECT_EQ(check.errors[0].path, "name");
    EXPECT_EQ(check.errors[1].path, "models.m.file");
    EXPECT_TRUE(check_scene("minimal").errors.empty());
    EXPECT_EQ(check_scene("/no/such.json").errors.at(0).message, "no such file");
    EXPECT_EQ(check_scene("/no/such.json").errors.at(0).path, "");
}

TEST(SceneReader, ALineOfAsManyAsASceneHasIsReadInNoTime) {
    json scene = cases().at("scene");
    for (std::size_t i = scene["actors"].size(); i < 5000; ++i)
        scene["actors"].push_back(
            {{"name", "walker number " + std::to_string(i)},
             {"model", "man"},
             {"behaviour", {{"type", "follow"}, {"actor", scene["actors"].back()["name"].get<std::string>()}}}});
    const auto begin = std::chrono::steady_clock::now();
    const auto good = read(scene);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20)) << "minutes, step for step";
    ASSERT_TRUE(good) << good.error().message;
    scene["actors"][4]["behaviour"] = scene["actors"].back()["behaviour"];
    EXPECT_THAT(read(scene).error().message,
                HasSubstr("actors[4].behaviour: 'puppet' follows 'walker number 4998' fol"));
}

TEST(SceneReader, AnObjectOnAnActorWhoseModelIsMissingIsAnErrorOfTheActor) {
    json scene = cases().at("scene");
    scene["actors"][1]["model"] = "none";  // "bag" hangs on this actor
    EXPECT_THAT(read(scene).error().message, HasSubstr("actors[1].model: no model 'none'"));
}

TEST(Shapes, StandOnTheirOriginAndFaceWhoSeesThem) {
    const auto outward = [](const ModelRef& model) {
        const Primitive& p = model->meshes[0].primitives[0];
        for (std::size_t i = 0; i < p.indices.size(); i += 3) {
            const glm::vec3 a = p.positions[p.indices[i]], b = p.positions[p.indices[i + 1]],
                            c = p.positions[p.indices[i + 2]];
            const glm::vec3 normal = glm::cross(b - a, c - a);
            // At the sky's poles triangles have no area.
            if (!(glm::length(normal) > 1e-9f)) continue;
            EXPECT_GT(glm::dot(normal, p.normals[p.indices[i]]), 0.0f) << i;
        }
        return p.bounds;
    };
    const Box box = outward(shape_model(BoxShape{.size = {1.0, 2.0, 3.0}}));  // glTF's axes: y up
    EXPECT_LT(glm::distance(box.min, glm::vec3(-0.5f, 0.0f, -1.0f)), 1e-6f);
    EXPECT_LT(glm::distance(box.max, glm::vec3(0.5f, 3.0f, 1.0f)), 1e-6f);
    const Box ground = outward(shape_model(GroundShape{.size = {10.0, 20.0}}));
    EXPECT_LT(glm::distance(ground.max, glm::vec3(5.0f, 0.0f, 10.0f)), 1e-5f);
    const ModelRef sky = shape_model(SkyShape{.radius_m = 100.0});
    EXPECT_LT(glm::distance(outward(sky).max, glm::vec3(100.0f)), 1e-2f);
    EXPECT_LT(glm::dot(sky->meshes[0].primitives[0].positions[5], sky->meshes[0].primitives[0].normals[5]), 0.0f);
}

TEST(SceneOfModel, ABareModelStandsOnAGroundJustBelowItUnlessToldOtherwise) {
    const auto scene = scene_of_model(box_model());
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_EQ(scene->objects.size(), 3u);
    EXPECT_EQ(scene->objects[0].name, "model");
    EXPECT_EQ(scene->objects[1].object_class, "ground");
    EXPECT_LT(scene->objects[1].position.z, 0.0);
    EXPECT_GT(scene->objects[1].position.z, -0.01);
    EXPECT_EQ(scene->objects[2].object_class, "sky");
    EXPECT_EQ(scene_of_model(box_model(), {.bare_ground = false})->objects.size(), 1u);
}

TEST(SceneOfModel, FramesABareModelAndLoopsItsFirstClip) {
    const auto scene = scene_of_model(box_model());
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->objects[0].clip, "walk");
    ASSERT_EQ(scene->cameras.size(), 1u);
    EXPECT_EQ(scene->cameras[0].name, "main");
    EXPECT_EQ(scene->lights.size(), 1u);
}

TEST(SceneOfModel, TheCameraOfABareModelSeesAllOfItWhereverItLies) {
    GlbBuilder glb;
    glb.mesh({10, 2, 3, 12, 2, 3, 10, 5, 7});
    const auto model = load_model(glb.build(), {}, "test");
    ASSERT_TRUE(model) << model.error().message;
    const auto scene = scene_of_model(*model);
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_EQ(scene->cameras.size(), 1u);
    const camera::Pose& pose = scene->cameras[0].pose;
    const glm::dvec3 ahead = pose.orientation * glm::dvec3(1, 0, 0);
    double widest = 0.0;
    for (const auto& corner : {glm::dvec3(10, -3, 2), glm::dvec3(12, -3, 2), glm::dvec3(10, -7, 5)})
        widest = std::max(widest, std::acos(glm::dot(glm::normalize(corner - pose.position), ahead)));
    EXPECT_LT(widest, glm::radians(30.0));
    EXPECT_GT(widest, glm::radians(10.0));  // nor is it far away
    EXPECT_NEAR(scene->objects[1].position.z, 2.0, 0.01);
}

TEST(SceneOfModel, TakesTheModelsCamerasAndLights) {
    GlbBuilder glb;
    glb.mesh({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const json camera = {{"type", "perspective"},
                         {"name", "Front Door"},
                         {"perspective", {{"yfov", 0.7}, {"znear", 0.2}, {"aspectRatio", 2.0}}}};
    glb.json["cameras"] = json::array({camera});
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
    const camera::Pose& pose = scene->cameras[0].pose;
    EXPECT_EQ(pose.position, glm::dvec3(0, -5, 1));
    EXPECT_LT(glm::distance(pose.orientation * glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)), 1e-12);
    EXPECT_LT(glm::distance(pose.orientation * glm::dvec3(0, 0, 1), glm::dvec3(0, 0, 1)), 1e-12);
    ASSERT_EQ(scene->lights.size(), 1u);
    EXPECT_EQ(scene->lights[0].name, "model.bulb");
    EXPECT_EQ(scene->lights[0].position, glm::dvec3(0, 0, 2));
}

}  // namespace
}  // namespace camrig::world::scene_loader_test
