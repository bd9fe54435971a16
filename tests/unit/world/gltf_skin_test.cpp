#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/world/gltf_loader.h"
#include "tests/unit/world/glb_builder.h"

namespace camrig::world::gltf_skin_test {
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

/// A skinned triangle: one joint per entry of `joints`, which is also the joint count of the skin.
GlbBuilder skinned(const std::vector<float>& weights, std::uint8_t joint = 0) {
    GlbBuilder glb;
    std::vector<std::uint8_t> joints(12, joint);
    const int j = glb.bytes(joints, "VEC4");
    const int w = glb.floats(weights, "VEC4");
    glb.mesh(triangle, {{"attributes", {{"JOINTS_0", j}, {"WEIGHTS_0", w}}}});
    glb.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}, {{"name", "joint"}}};
    glb.json["scenes"] = {{{"nodes", {0, 1}}}};
    glb.json["skins"] = {{{"joints", {1}}}};
    return glb;
}

TEST(GltfSkins, WeightsAreNormalisedAndVerticesWithoutAnyFollowTheirFirstJoint) {
    const auto model = load(skinned({2, 0, 0, 0, 0, 0, 0, 0, 0.5f, 0.25f, 0, 0}));
    ASSERT_TRUE(model) << model.error().message;
    for (const glm::vec4& w : (*model)->meshes[0].primitives[0].weights)
        EXPECT_NEAR(w.x + w.y + w.z + w.w, 1.0f, 1e-6f);
}

TEST(GltfSkins, JointsBeyondTheSkinAndNegativeWeightsAreErrors) {
    const std::vector<float> full = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    EXPECT_THAT(error_of(skinned(full, 1)), HasSubstr("uses joint 1 of 1"));
    EXPECT_THAT(error_of(skinned({1, -1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0})), HasSubstr("negative"));
}

/// A triangle whose vertices have these eight joints and weights, and a skin of ten joints.
GlbBuilder eight_joints(const std::vector<std::uint16_t>& joints, const std::vector<float>& weights) {
    GlbBuilder glb;
    nlohmann::json attributes;
    for (std::size_t set = 0; set < 2; ++set) {
        std::vector<std::uint16_t> j;
        std::vector<float> w;
        for (int vertex = 0; vertex < 3; ++vertex) {
            j.insert(j.end(), joints.begin() + static_cast<std::ptrdiff_t>(set * 4),
                     joints.begin() + static_cast<std::ptrdiff_t>(set * 4 + 4));
            w.insert(w.end(), weights.begin() + static_cast<std::ptrdiff_t>(set * 4),
                     weights.begin() + static_cast<std::ptrdiff_t>(set * 4 + 4));
        }
        attributes["JOINTS_" + std::to_string(set)] = glb.shorts(j, "VEC4");
        attributes["WEIGHTS_" + std::to_string(set)] = glb.floats(w, "VEC4");
    }
    glb.mesh(triangle, {{"attributes", attributes}});
    glb.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}};
    std::vector<int> roots = {0}, skin;
    for (int joint = 1; joint <= 10; ++joint) {
        glb.json["nodes"].push_back({{"name", "joint_" + std::to_string(joint)}});
        roots.push_back(joint);
        skin.push_back(joint);
    }
    glb.json["scenes"] = {{{"nodes", roots}}};
    glb.json["skins"] = {{{"joints", skin}}};
    return glb;
}

TEST(GltfSkins, OfEightJointsTheFourStrongestCount) {
    const auto model = load(eight_joints({0, 1, 2, 3, 4, 5, 6, 9}, {0.02f, 0.3f, 0.1f, 0, 0.04f, 0.2f, 0.02f, 0.32f}));
    ASSERT_TRUE(model) << model.error().message;
    const Primitive& primitive = (*model)->meshes[0].primitives[0];
    EXPECT_EQ(primitive.joints[2], glm::u16vec4(9, 1, 5, 2));
    const double sum = 0.32 + 0.3 + 0.2 + 0.1;
    EXPECT_NEAR(primitive.weights[2].x, 0.32 / sum, 1e-6);
    EXPECT_NEAR(primitive.weights[2].w, 0.1 / sum, 1e-6);
    EXPECT_NEAR(glm::dot(primitive.weights[2], glm::vec4(1)), 1.0f, 1e-6f);
}

TEST(GltfSkins, JointsOfTheSecondSetMustBeInTheSkinWhenTheyCount) {
    EXPECT_THAT(error_of(eight_joints({0, 0, 0, 0, 10, 0, 0, 0}, {0, 0, 0, 0, 1, 0, 0, 0})),
                HasSubstr("uses joint 10 of 10"));
    const auto unused = load(eight_joints({0, 0, 0, 0, 10, 0, 0, 0}, {1, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_TRUE(unused) << unused.error().message;
    auto half = eight_joints({0, 0, 0, 0, 1, 0, 0, 0}, {0.5f, 0, 0, 0, 0.5f, 0, 0, 0});
    half.json["meshes"][0]["primitives"][0]["attributes"].erase("WEIGHTS_1");
    const auto model = load(half);
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ((*model)->meshes[0].primitives[0].weights[0], glm::vec4(1, 0, 0, 0));
}

TEST(GltfSkins, ASecondSetOfAnotherLengthIsAnError) {
    auto glb = eight_joints({0, 0, 0, 0, 1, 0, 0, 0}, {0.5f, 0, 0, 0, 0.5f, 0, 0, 0});
    glb.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_1"] = glb.shorts({0, 0, 0, 0}, "VEC4");
    EXPECT_THAT(error_of(glb), HasSubstr("attributes.JOINTS_1: joints and weights do not match"));
}

TEST(GltfSkins, DamagedBytesNeverCrash) {
    const auto whole = skinned({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}).build();
    for (std::uint64_t round = 0; round < 3000; ++round) {
        auto damaged = whole;
        for (std::uint64_t k = 0; k < 1 + round % 4; ++k) {
            const std::uint64_t bits = random_bits(7, round, k);
            damaged[bits % damaged.size()] = static_cast<std::byte>(bits >> 56);
        }
        (void)load_model(damaged, {}, "test");
    }
}

}  // namespace
}  // namespace camrig::world::gltf_skin_test
