#include "core/world/baked/baked_light_file.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/world/baked/baked_light_header.h"
#include "core/world/scene_check.h"
#include "tests/temporary_folder.h"
#include "tests/unit/bake/scenes.h"

namespace camrig::world {
namespace {

using bake::TestBox;

const std::vector<TestBox> boxes{{"ground", {0, 0, -0.2}, {4, 4, 0.2}, 0.3}, {"block", {1, 0, 0}, {1, 1, 1}, 0.6}};
const std::string lamp = R"(, "lights": [{"name": "lamp", "type": "point", "position": [0, 0, 1]}])";

struct BakedFile : ::testing::Test {
    SceneRef scene = bake::scene_of(boxes, lamp);
    BakedLight light = bake::baked(scene, {.texels_per_m = 4.0, .rays = 32});
    std::vector<std::byte> bytes = encode_baked_light(light);
};

TEST_F(BakedFile, IsReadAsItWasWritten) {
    const auto read = decode_baked_light(bytes, *scene);
    ASSERT_TRUE(read.has_value()) << read.error().message;
    EXPECT_EQ((*read)->key, light.key);
    EXPECT_EQ((*read)->size, light.size);
    ASSERT_EQ((*read)->objects.size(), light.objects.size());
    for (std::size_t i = 0; i < light.objects.size(); ++i)
        EXPECT_EQ((*read)->objects[i].surfaces, light.objects[i].surfaces);
    ASSERT_EQ((*read)->layers.size(), light.layers.size());
    for (std::size_t i = 0; i < light.layers.size(); ++i) {
        EXPECT_EQ((*read)->layers[i].source, light.layers[i].source);
        EXPECT_EQ((*read)->layers[i].probes.size(), light.layers[i].probes.size());
    }
    EXPECT_EQ(encode_baked_light(**read), bytes);
}

TEST_F(BakedFile, IsOfOneStateOfItsScene) {
    auto moved = boxes;
    moved[1].position.x += 0.01;
    const auto read = decode_baked_light(bytes, *bake::scene_of(moved, lamp));
    ASSERT_FALSE(read.has_value());
    EXPECT_EQ(read.error().kind, ErrorKind::unsupported);
    const auto stronger = bake::scene_of(
        boxes, R"(, "lights": [{"name": "lamp", "type": "point", "position": [0, 0, 1], "intensity": 3}])");
    EXPECT_TRUE(decode_baked_light(bytes, *stronger).has_value()) << "strengths are not baked";
    Scene mirroring = *scene;
    auto block = std::make_shared<Model>(*mirroring.models.at("block").model);
    block->materials.front().roughness = 0.0f;
    mirroring.models.at("block").model = block;
    EXPECT_FALSE(decode_baked_light(bytes, mirroring).has_value()) << "what is mirrored is baked where mirrors are";
}

TEST_F(BakedFile, OfAnotherStateIsNoErrorOfTheScene) {
    const TemporaryFolder folder;
    std::ofstream(folder / "x.json") << R"({"camrig_scene": 1, "name": "x", "models": {"box": {"shape": "box"}},
        "objects": [{"name": "other", "model": "box"}]})";
    std::ofstream(folder / "x.light", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    const SceneCheck check = check_scene(folder / "x.json");
    EXPECT_NE(check.scene, nullptr);
    EXPECT_THAT(check.errors, testing::IsEmpty());
}

TEST_F(BakedFile, TakesNoMemoryForMoreTexelsThanCanBe) {
    nlohmann::json text = baked_light_header(light);
    text["size"] = {8192, 8192};
    const auto read = read_baked_light_header(text, *scene);
    ASSERT_FALSE(read.has_value());
    EXPECT_EQ(read.error().kind, ErrorKind::resource_exhausted);
    EXPECT_THAT(read.error().message, ::testing::HasSubstr("layers: more than"));
}

TEST_F(BakedFile, TakesNoMemoryForMoreProbesThanCanBe) {
    nlohmann::json text = baked_light_header(light);
    text["grid"]["count"] = {128, 128, 64};  // of two layers these could be
    const auto read = read_baked_light_header(text, *scene);
    ASSERT_FALSE(read.has_value());
    EXPECT_EQ(read.error().kind, ErrorKind::resource_exhausted);
    EXPECT_THAT(read.error().message, ::testing::HasSubstr("grid.count: more than"));
}

TEST_F(BakedFile, NamesLampsThatTheSceneHas) {
    const auto told = [&](const nlohmann::json& lamps) {
        nlohmann::json text = baked_light_header(light);
        text["layers"].back()["lamps"] = lamps;
        const auto read = read_baked_light_header(text, *scene);
        return read ? std::string() : read.error().message;
    };
    EXPECT_EQ(told({0}), "");
    for (const nlohmann::json& wrong :
         {nlohmann::json{1}, nlohmann::json{-1}, nlohmann::json(0), nlohmann::json{"lamp"}})
        EXPECT_THAT(told(wrong), ::testing::HasSubstr("layers[2].lamps: numbers of lights that the scene has"))
            << wrong;
    EXPECT_THAT(told(nlohmann::json::array()), ::testing::HasSubstr("those of lamps, and no others"));
}

TEST_F(BakedFile, HasTheTrianglesOfTheModelsFile) {
    BakedLight forged = light;
    auto& indices = forged.models[0].primitives[0].indices;
    std::swap(indices[0], indices[1]);
    const auto read = decode_baked_light(encode_baked_light(forged), *scene);
    ASSERT_FALSE(read.has_value());
    EXPECT_THAT(read.error().message, ::testing::HasSubstr("is none of this model"));
}

TEST_F(BakedFile, CutShortAnywhereIsAnError) {
    for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 40) {
        const auto read = decode_baked_light(std::span(bytes).first(size), *scene);
        ASSERT_FALSE(read.has_value()) << size;
        EXPECT_FALSE(read.error().message.empty());
    }
}

TEST_F(BakedFile, DamagedBytesAreAnErrorOrOtherLight) {
    for (std::uint64_t i = 0; i < 400; ++i) {
        auto damaged = bytes;
        // Half of them in its text.
        const std::size_t range = i % 2 == 0 ? std::min<std::size_t>(600, bytes.size()) : bytes.size();
        damaged[static_cast<std::size_t>(random_unit(1, i, 0) * static_cast<double>(range))] ^=
            static_cast<std::byte>(1 + random_bits(1, i, 1) % 255);
        const auto read = decode_baked_light(damaged, *scene);
        if (!read) {
            EXPECT_FALSE(read.error().message.empty());
            continue;
        }
        Scene used(*scene);
        use_baked_light(used, *read);
    }
}

}  // namespace
}  // namespace camrig::world
