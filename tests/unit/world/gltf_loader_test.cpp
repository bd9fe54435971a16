#include "core/world/gltf_loader.h"

#include <fstream>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"
#include "tests/unit/world/glb_builder.h"

namespace camrig::world::gltf_loader_test {
namespace {

using testing::HasSubstr;

const std::vector<float> triangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};

Result<ModelRef> load(const GlbBuilder& builder) {
    return load_model(builder.build(), {}, "test");
}

std::string error_of(const GlbBuilder& builder) {
    const auto model = load(builder);
    return model ? "loaded" : model.error().message;
}

TEST(GltfLoader, ATriangleWithoutNormalsBecomesFlat) {
    GlbBuilder glb;
    const auto model = load(glb.mesh(triangle));
    ASSERT_TRUE(model) << model.error().message;
    const Primitive& primitive = (*model)->meshes[0].primitives[0];
    EXPECT_EQ(primitive.indices, (std::vector<std::uint32_t>{0, 1, 2}));
    for (const glm::vec3& normal : primitive.normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
    EXPECT_EQ(primitive.bounds.max, glm::vec3(1, 1, 0));
}

TEST(GltfLoader, AllPrimitiveModesBecomeListsWithTheStandardsWinding) {
    const std::vector<float> four = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    using Indices = std::vector<std::uint32_t>;
    const std::vector<std::pair<int, Indices>> cases = {
        {0, {0, 1, 2, 3}}, {1, {0, 1, 2, 3}},       {2, {0, 1, 1, 2, 2, 3, 3, 0}}, {3, {0, 1, 1, 2, 2, 3}},
        {4, {0, 1, 2}},    {5, {0, 1, 2, 1, 3, 2}}, {6, {1, 2, 0, 2, 3, 0}}};
    for (const auto& [mode, indices] : cases) {
        GlbBuilder glb;
        const int normals = glb.floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
        const auto model = load(glb.mesh(four, {{"mode", mode}, {"attributes", {{"NORMAL", normals}}}}));
        ASSERT_TRUE(model) << model.error().message;
        EXPECT_EQ((*model)->meshes[0].primitives[0].indices, indices) << "mode " << mode;
    }
}

TEST(GltfLoader, IndicesBeyondTheVerticesAreAnErrorWithTheirPlace) {
    GlbBuilder glb;
    const int indices = glb.shorts({0, 1, 3}, "SCALAR");
    EXPECT_EQ(error_of(glb.mesh(triangle, {{"indices", indices}})),
              "test: meshes[0].primitives[0].indices: index 3 of 3 vertices");
}

TEST(GltfLoader, AnAccessorThatLeavesItsViewIsAnError) {
    GlbBuilder glb;
    glb.mesh(triangle);
    for (const std::uint64_t count : {4ull, 1000000ull, 0x7fffffffull, 0ull}) {
        glb.json["accessors"][0]["count"] = count;
        EXPECT_THAT(error_of(glb), HasSubstr("meshes[0].primitives[0].attributes.POSITION")) << count;
    }
    glb.json["accessors"][0]["count"] = std::uint64_t{1} << 62;
    EXPECT_THAT(error_of(glb), HasSubstr("accessors[0].count: expected an integer"));
    glb.json["accessors"][0]["count"] = 3;
    glb.json["accessors"][0]["byteOffset"] = 2147483647;
    EXPECT_THAT(error_of(glb), HasSubstr("do not fit"));
    glb.json["accessors"][0].erase("byteOffset");
    glb.json["bufferViews"][0]["byteStride"] = 4;
    EXPECT_THAT(error_of(glb), HasSubstr("byteStride"));
    glb.json["bufferViews"][0]["byteStride"] = 252;
    EXPECT_THAT(error_of(glb), HasSubstr("do not fit"));
    glb.json["bufferViews"][0] = {{"buffer", 0}, {"byteOffset", 30}, {"byteLength", 36}};
    EXPECT_THAT(error_of(glb), HasSubstr("leaves the buffer"));
    glb.json["bufferViews"][0]["buffer"] = 7;
    EXPECT_THAT(error_of(glb), HasSubstr("buffer 7 of 1"));
}

TEST(GltfLoader, NumbersThatAreNotFiniteAreErrors) {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e20f}) {
        GlbBuilder glb;
        EXPECT_THAT(error_of(glb.mesh({0, 0, 0, 1, bad, 0, 0, 1, 0})), HasSubstr("not finite"));
    }
}

TEST(GltfLoader, SparseAccessorsReplaceElements) {
    GlbBuilder glb;
    glb.mesh(triangle);
    const std::vector<std::uint8_t> places = {2};
    const std::vector<float> values = {5, 6, 7};
    const int place_view = glb.view(places.data(), places.size());
    const int value_view = glb.view(values.data(), values.size() * 4);
    auto& accessor = glb.json["accessors"][0];
    accessor["sparse"] = {{"count", 1},
                          {"indices", {{"bufferView", place_view}, {"componentType", 5121}}},
                          {"values", {{"bufferView", value_view}}}};
    const auto model = load(glb);
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ((*model)->meshes[0].primitives[0].positions[2], glm::vec3(5, 6, 7));
    glb.binary[glb.json["bufferViews"][static_cast<std::size_t>(place_view)]["byteOffset"].get<std::size_t>()] =
        std::byte{3};
    EXPECT_THAT(error_of(glb), HasSubstr("sparse.indices"));
}

TEST(GltfLoader, QuantizedPositionsNeedTheExtension) {
    GlbBuilder glb;
    const std::vector<std::int16_t> values = {0, 0, 0, 0, 32767, 0, 0, 0, 0, -32767, 0, 0};
    glb.mesh(triangle);
    const int accessor = glb.accessor(values, "VEC4", 5122, true);
    glb.json["accessors"][static_cast<std::size_t>(accessor)]["type"] = "VEC3";
    glb.json["bufferViews"].back()["byteStride"] = 8;
    glb.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = accessor;
    EXPECT_THAT(error_of(glb), HasSubstr("component type 5122 (normalized) is not allowed"));
    glb.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    glb.json["extensionsUsed"] = {"KHR_mesh_quantization"};
    const auto model = load(glb);
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ((*model)->meshes[0].primitives[0].positions[1], glm::vec3(1, 0, 0));
    EXPECT_EQ((*model)->meshes[0].primitives[0].positions[2], glm::vec3(0, -1, 0));
}

TEST(GltfLoader, AnUnknownRequiredExtensionIsNamed) {
    GlbBuilder glb;
    glb.mesh(triangle).json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    const auto model = load(glb);
    ASSERT_FALSE(model);
    EXPECT_EQ(model.error().kind, ErrorKind::unsupported);
    EXPECT_THAT(model.error().message, HasSubstr("KHR_draco_mesh_compression"));
}

TEST(GltfLoader, HierarchiesWithCyclesAndTwoParentsAreErrors) {
    GlbBuilder glb;
    glb.mesh(triangle);
    glb.json["nodes"] = {{{"mesh", 0}}, {{"children", {2}}}, {{"children", {1}}}};
    EXPECT_THAT(error_of(glb), HasSubstr("the hierarchy has a cycle"));
    glb.json["nodes"] = {{{"children", {2}}}, {{"children", {2}}}, {{"mesh", 0}}};
    EXPECT_THAT(error_of(glb), HasSubstr("two parents"));
    glb.json["nodes"] = {{{"children", {0}}}};
    EXPECT_THAT(error_of(glb), HasSubstr("cycle"));
    glb.json["nodes"] = {{{"children", {9}}}};
    EXPECT_THAT(error_of(glb), HasSubstr("nodes[0].children: node 9 of 1"));
}

TEST(GltfLoader, ADeepHierarchyIsAnErrorAndNoStackOverflow) {
    GlbBuilder glb;
    auto& nodes = glb.json["nodes"];
    for (int i = 0; i < 100000; ++i) nodes.push_back({{"children", {i + 1}}});
    nodes.push_back({{"name", "leaf"}});
    EXPECT_THAT(error_of(glb), HasSubstr("nested deeper than 1024"));
}

GlbBuilder animated(const std::vector<float>& times, const std::vector<float>& values) {
    GlbBuilder glb;
    const int input = glb.floats(times, "SCALAR");
    const int output = glb.floats(values, "VEC3");
    glb.mesh(triangle);
    glb.json["animations"] = {{{"name", "move"},
                               {"extras", {{"ground_speed_m_s", 1.25}}},
                               {"samplers", {{{"input", input}, {"output", output}}}},
                               {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
    return glb;
}

TEST(GltfLoader, ALargeMeshOnVeryManyNodesIsAnError) {
    GlbBuilder glb;
    std::vector<float> positions;
    for (int i = 0; i < 30000; ++i) positions.insert(positions.end(), triangle.begin(), triangle.end());
    glb.mesh(positions);
    for (int i = 1; i < 1000; ++i) glb.json["nodes"].push_back({{"mesh", 0}});
    EXPECT_THAT(error_of(glb), HasSubstr("nodes: their meshes have more than 67108864 vertices in all"));
}

TEST(GltfLoader, ManyIndicesOnVeryManyNodesAreAnError) {
    GlbBuilder glb;
    glb.mesh(triangle);
    auto& primitive = glb.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["NORMAL"] = glb.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");  // or each corner is a vertex
    primitive["indices"] = glb.accessor(std::vector<std::uint32_t>(3'000'000, 0), "SCALAR", 5125);
    for (int i = 1; i < 100; ++i) glb.json["nodes"].push_back({{"mesh", 0}});
    EXPECT_THAT(error_of(glb), HasSubstr("nodes: their meshes have more than 268435456 indices in all"));
}

TEST(GltfLoader, ManyPrimitivesOnVeryManyNodesAreAnError) {
    GlbBuilder glb;
    glb.mesh(triangle);
    auto& primitives = glb.json["meshes"][0]["primitives"];
    const auto first = primitives[0];
    for (int i = 1; i < 1000; ++i) primitives.push_back(first);
    for (int i = 1; i < 300; ++i) glb.json["nodes"].push_back({{"mesh", 0}});
    EXPECT_THAT(error_of(glb), HasSubstr("nodes: their meshes have more than 262144 primitives in all"));
}

TEST(GltfLoader, AnimationsKeepTheirKeysInNanoseconds) {
    const auto model = load(animated({0, 0.5f, 2}, {0, 0, 0, 1, 0, 0, 2, 0, 0}));
    ASSERT_TRUE(model) << model.error().message;
    const Animation& clip = (*model)->animations[0];
    EXPECT_EQ(clip.duration_ns, 2 * ns_per_s);
    EXPECT_EQ(clip.channels[0].times_ns, (std::vector<TimeNs>{0, 500'000'000, 2'000'000'000}));
    EXPECT_EQ(clip.ground_speed_m_s, 1.25);
    EXPECT_EQ((*model)->find_animation("move"), 0);
    EXPECT_EQ((*model)->find_animation("walk"), -1);
}

TEST(GltfLoader, AnimationsWithFallingTimesOrMissingValuesAreErrors) {
    EXPECT_THAT(error_of(animated({0, 1, 1}, {0, 0, 0, 1, 0, 0, 2, 0, 0})), HasSubstr("key times do not rise"));
    EXPECT_THAT(error_of(animated({-1, 1, 2}, {0, 0, 0, 1, 0, 0, 2, 0, 0})), HasSubstr("negative"));
    EXPECT_THAT(error_of(animated({0, 1, 2}, {0, 0, 0, 1, 0, 0})), HasSubstr("6 numbers for 3 keys of 3"));
    auto glb = animated({0, 1}, {0, 0, 0, 1, 0, 0});
    glb.json["animations"][0]["channels"][0]["target"]["node"] = 5;
    EXPECT_THAT(error_of(glb), HasSubstr("animations[0].channels[0].target.node: node 5 of 1"));
}

TEST(GltfLoader, FilesOutsideTheFolderAreRefused) {
    const TemporaryFolder around;
    const auto folder = around / "confined";
    std::filesystem::create_directories(folder);
    std::ofstream(around / "outside.bin") << std::string(36, '\0');
    std::filesystem::create_symlink("../outside.bin", folder / "link.bin");
    for (const char* uri : {"../outside.bin", "/etc/passwd", "%2e%2e/outside.bin", "link.bin", "file:///etc/passwd",
                            "a/../../outside.bin", "missing.bin"}) {
        GlbBuilder glb;
        glb.mesh(triangle);
        nlohmann::json document = glb.json;
        document["buffers"] = {{{"byteLength", 36}, {"uri", uri}}};
        const std::string text = document.dump();
        const auto model = load_model(std::as_bytes(std::span(text)), folder, "test.gltf");
        ASSERT_FALSE(model) << uri;
        EXPECT_THAT(model.error().message, HasSubstr("test.gltf: buffers[0].uri")) << uri;
    }
}

TEST(GltfLoader, AMissingTextureFileIsAnErrorThatNamesIt) {
    GlbBuilder glb;
    glb.mesh(triangle);
    glb.json["images"] = {{{"uri", "wood.png"}}};
    glb.json["textures"] = {{{"source", 0}}};
    const auto model = load_model(glb.build(), testing::TempDir(), "test");
    ASSERT_FALSE(model);
    EXPECT_EQ(model.error().kind, ErrorKind::not_found);
    EXPECT_THAT(model.error().message, HasSubstr("images[0].uri: 'wood.png' no such file"));
}

TEST(GltfLoader, DataUrisCarryPictures) {
    GlbBuilder glb;
    glb.mesh(triangle);
    // One red pixel.
    glb.json["images"] = {{{"uri",
                            "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4"
                            "2mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg=="}}};
    glb.json["textures"] = {{{"source", 0}}};
    const auto model = load(glb);
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ((*model)->images[0].size, (ImageSize{1, 1}));
    EXPECT_EQ((*model)->images[0].rgba.size(), 4u);
}

TEST(GltfLoader, TruncatedFilesAreErrors) {
    GlbBuilder glb;
    const auto whole = glb.mesh(triangle).build();
    ASSERT_TRUE(load_model(whole, {}, "test"));
    for (std::size_t size = 0; size < whole.size(); ++size) {
        EXPECT_FALSE(load_model(std::span(whole).first(size), {}, "test")) << size;
    }
}

TEST(GltfLoader, WrongTypesAreErrorsWithThePathNotDefaults) {
    GlbBuilder glb;
    glb.mesh(triangle);
    auto bad = glb;
    bad.json["nodes"][0]["mesh"] = "zero";
    EXPECT_THAT(error_of(bad), HasSubstr("nodes[0].mesh: expected an integer"));
    bad = glb;
    bad.json["nodes"][0]["translation"] = {1, 2};
    EXPECT_THAT(error_of(bad), HasSubstr("nodes[0].translation: expected an array of 3 numbers"));
    bad = glb;
    bad.json["nodes"][0]["rotation"] = {0, 0, 0, 0};
    EXPECT_THAT(error_of(bad), HasSubstr("nodes[0].rotation: is not a rotation"));
    bad = glb;
    bad.json["meshes"][0]["primitives"].push_back(5);
    EXPECT_THAT(error_of(bad), HasSubstr("meshes[0]"));
    bad = glb;
    bad.json["asset"]["version"] = "1.0";
    EXPECT_THAT(error_of(bad), HasSubstr("glTF 2.0 is read"));
}

}  // namespace
}  // namespace camrig::world::gltf_loader_test
