#include "core/world/posed_model.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/world/gltf_loader.h"
#include "core/world/interpolate.h"
#include "tests/unit/world/glb_builder.h"

namespace camrig::world::posed_model_test {
namespace {

double random_signed(std::uint64_t stream, std::uint64_t i) {
    return random_unit(11, stream, i) * 2.0 - 1.0;
}

glm::dquat random_rotation(std::uint64_t stream) {
    return glm::normalize(glm::dquat(random_signed(stream, 0), random_signed(stream, 1), random_signed(stream, 2),
                                     random_signed(stream, 3)));
}

/// The textbook formula in long double, along the shorter arc.
std::array<long double, 4> reference_slerp(const glm::dquat& a, glm::dquat b, long double t) {
    if (glm::dot(a, b) < 0.0) b = -b;
    const std::array<long double, 4> qa = {a.w, a.x, a.y, a.z}, qb = {b.w, b.x, b.y, b.z};
    long double less = 0, more = 0;
    for (int i = 0; i < 4; ++i) {
        less += (qa[i] - qb[i]) * (qa[i] - qb[i]);
        more += (qa[i] + qb[i]) * (qa[i] + qb[i]);
    }
    const long double angle = 2 * std::atan2(std::sqrt(less), std::sqrt(more));
    std::array<long double, 4> out{};
    for (int i = 0; i < 4; ++i) {
        out[i] = angle < 1e-15L ? qa[i] + t * (qb[i] - qa[i])
                                : (std::sin((1 - t) * angle) * qa[i] + std::sin(t * angle) * qb[i]) / std::sin(angle);
    }
    return out;
}

void expect_matches_reference(const glm::dquat& a, const glm::dquat& b, double t) {
    const glm::dquat q = slerp_shortest(a, b, t);
    const auto r = reference_slerp(a, b, t);
    EXPECT_NEAR(q.w, static_cast<double>(r[0]), 2e-15);
    EXPECT_NEAR(q.x, static_cast<double>(r[1]), 2e-15);
    EXPECT_NEAR(q.y, static_cast<double>(r[2]), 2e-15);
    EXPECT_NEAR(q.z, static_cast<double>(r[3]), 2e-15);
}

TEST(Slerp, AgreesWithLongDoubleForRandomNearAndFarKeys) {
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const glm::dquat a = random_rotation(i);
        const double t = random_unit(3, i, 0);
        expect_matches_reference(a, random_rotation(i + 100000), t);
        for (const double angle : {1e-12, 1e-9, 1e-8, 1e-7, 1e-5, 1e-3, 3.0, std::numbers::pi}) {
            const glm::dquat turn = glm::angleAxis(
                angle, glm::normalize(glm::dvec3(random_signed(i, 7), random_signed(i, 8), random_signed(i, 9))));
            expect_matches_reference(a, glm::normalize(turn * a), t);
        }
    }
}

TEST(Slerp, ANegatedQuaternionIsTheSameRotation) {
    const glm::dquat a = random_rotation(1);
    const glm::dquat q = slerp_shortest(a, -a, 0.3);
    EXPECT_NEAR(std::abs(glm::dot(a, q)), 1.0, 1e-15);
    // 21 degrees must never become 339.
    const glm::dquat b = -(glm::angleAxis(glm::radians(21.0), glm::dvec3(0, 0, 1)) * a);
    EXPECT_NEAR(2.0 * std::acos(std::abs(glm::dot(a, slerp_shortest(a, b, 0.5)))), glm::radians(10.5), 1e-12);
}

ModelRef must_load(const GlbBuilder& glb) {
    auto model = load_model(glb.build(), {}, "test");
    EXPECT_TRUE(model) << (model ? "" : model.error().message);
    return model ? *model : nullptr;
}

/// A node that moves by one channel; `type` of the output.
ModelRef moving(const std::string& path, const std::string& interpolation, const std::vector<float>& times,
                const std::vector<float>& values, const std::string& type) {
    GlbBuilder glb;
    const int input = glb.floats(times, "SCALAR"), output = glb.floats(values, type);
    glb.json["nodes"] = {{{"name", "node"}}};
    glb.json["scenes"] = {{{"nodes", {0}}}};
    glb.json["animations"] = {{{"name", "clip"},
                               {"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}},
                               {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}}}};
    return must_load(glb);
}

glm::dvec3 place_at(const Model& model, TimeNs phase_ns) {
    PosedModel pose;
    const ClipState clip{.animation = 0, .phase_ns = phase_ns};
    pose_model(model, std::span(&clip, 1), pose);
    return glm::dvec3(pose.model_from_node[0][3]);
}

TEST(PoseModel, TurnsGltfsYUpIntoZUp) {
    GlbBuilder glb;
    glb.json["nodes"] = {{{"translation", {1, 2, 3}}}};
    glb.json["scenes"] = {{{"nodes", {0}}}};
    PosedModel pose;
    pose_model(*must_load(glb), {}, pose);
    EXPECT_EQ(glm::dvec3(pose.model_from_node[0][3]), glm::dvec3(1, -3, 2));
}

TEST(PoseModel, LinearStepAndCubicKeysMeetTheirDefinitions) {
    const auto linear = moving("translation", "LINEAR", {1, 2}, {0, 0, 0, 4, 0, 0}, "VEC3");
    EXPECT_EQ(place_at(*linear, 0).x, 0.0);
    EXPECT_EQ(place_at(*linear, 1'250'000'000).x, 1.0);
    EXPECT_EQ(place_at(*linear, 2 * ns_per_s).x, 4.0);
    const auto step = moving("translation", "STEP", {0, 1}, {0, 0, 0, 4, 0, 0}, "VEC3");
    EXPECT_EQ(place_at(*step, 999'999'999).x, 0.0);
    EXPECT_EQ(place_at(*step, ns_per_s).x, 4.0);
    // p(t) = t^3 over [0, 2]: values 0, 8 and slopes 0, 12; a Hermite spline gives every cubic exactly.
    const auto cubic =
        moving("translation", "CUBICSPLINE", {0, 2}, {0, 0, 0, 0, 0, 0, 0, 0, 0, 12, 0, 0, 8, 0, 0, 0, 0, 0}, "VEC3");
    for (const double t : {0.0, 0.3, 1.0, 1.7, 2.0})
        EXPECT_NEAR(place_at(*cubic, std::llround(t * 1e9)).x, t * t * t, 1e-12);
}

TEST(PoseModel, CubicRotationsStayUnit) {
    const auto model = moving("rotation", "CUBICSPLINE", {0, 1},
                              {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0}, "VEC4");
    PosedModel pose;
    for (TimeNs t = 0; t <= ns_per_s; t += 50'000'000) {
        const ClipState clip{.animation = 0, .phase_ns = t};
        pose_model(*model, std::span(&clip, 1), pose);
        EXPECT_NEAR(glm::determinant(glm::dmat3(pose.model_from_node[0])), 1.0, 1e-12);
    }
}

TEST(PoseModel, TwoClipsBlendByWeight) {
    auto model = std::make_shared<Model>(*moving("translation", "LINEAR", {0, 1}, {1, 0, 0, 1, 0, 0}, "VEC3"));
    Animation second = model->animations[0];
    second.name = "other";
    for (std::size_t i = 0; i < 2; ++i) second.channels[0].values[i * 3] = 5.0f;
    model->animations.push_back(second);
    const std::array<ClipState, 2> clips = {ClipState{.animation = 0, .weight = 0.75},
                                            ClipState{.animation = 1, .weight = 0.25}};
    PosedModel pose;
    pose_model(*model, clips, pose);
    EXPECT_NEAR(pose.model_from_node[0][3].x, 2.0, 1e-15);
}

/// A triangle with two morph targets; the file's weights are 0.5 and 0, the node's as given.
GlbBuilder morphing(const std::string& interpolation, const std::vector<float>& times,
                    const std::vector<float>& values) {
    GlbBuilder glb;
    const int up = glb.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3"),
              aside = glb.floats({1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3");
    const int input = glb.floats(times, "SCALAR"), output = glb.floats(values, "SCALAR");
    glb.mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{"targets", {{{"POSITION", up}}, {{"POSITION", aside}}}}});
    glb.json["meshes"][0]["weights"] = {0.5, 0};
    glb.json["animations"] = {{{"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}},
                               {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
    return glb;
}

std::vector<float> weights_at(const Model& model, TimeNs phase_ns) {
    PosedModel pose;
    const ClipState clip{.animation = 0, .phase_ns = phase_ns};
    pose_model(model, std::span(&clip, 1), pose);
    return pose.morph_weights[0];
}

TEST(PoseModel, WeightsChannelsMoveAllTargetsOfANode) {
    using Weights = std::vector<float>;
    const auto linear = must_load(morphing("LINEAR", {0, 1}, {0, 1, 1, -1}));
    EXPECT_EQ(weights_at(*linear, 0), (Weights{0, 1}));
    EXPECT_EQ(weights_at(*linear, 250'000'000), (Weights{0.25f, 0.5f}));
    EXPECT_EQ(weights_at(*linear, ns_per_s), (Weights{1, -1}));
    const auto step = must_load(morphing("STEP", {0, 1}, {0, 1, 1, -1}));
    EXPECT_EQ(weights_at(*step, 999'999'999), (Weights{0, 1}));
    // Per key: in-tangents of both, values of both, out-tangents of both. t^2 and 1 - t^2 over [0, 1].
    const auto cubic = must_load(morphing("CUBICSPLINE", {0, 1}, {0, 0, 0, 1, 0, 0, 2, -2, 1, 0, 0, 0}));
    const auto half = weights_at(*cubic, 500'000'000);
    EXPECT_NEAR(half[0], 0.25f, 1e-6f);
    EXPECT_NEAR(half[1], 0.75f, 1e-6f);
}

TEST(PoseModel, WithoutAClipMorphWeightsAreTheNodesElseTheMeshes) {
    auto glb = morphing("LINEAR", {0, 1}, {0, 1, 1, -1});
    PosedModel pose;
    pose_model(*must_load(glb), {}, pose);
    EXPECT_EQ(pose.morph_weights[0], (std::vector<float>{0.5f, 0.0f}));
    glb.json["nodes"][0]["weights"] = {0.125, 2};
    pose_model(*must_load(glb), {}, pose);
    EXPECT_EQ(pose.morph_weights[0], (std::vector<float>{0.125f, 2.0f}));
}

TEST(PoseModel, WeightsChannelsWithoutTargetsOrOfAnotherWidthAreErrors) {
    const auto message = [](const GlbBuilder& glb) {
        const auto model = load_model(glb.build(), {}, "test");
        return model ? "loaded" : model.error().message;
    };
    EXPECT_THAT(message(morphing("LINEAR", {0, 1}, {0, 1, 1})), testing::HasSubstr("3 numbers for 2 keys of 2"));
    auto glb = morphing("LINEAR", {0, 1}, {0, 1, 1, 0});
    glb.json["nodes"].push_back({{"name", "plain"}});
    glb.json["animations"][0]["channels"][0]["target"]["node"] = 1;
    EXPECT_THAT(message(glb), testing::HasSubstr("without morph targets"));
}

}  // namespace
}  // namespace camrig::world::posed_model_test
