
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/world/gltf_loader.h"
#include "core/world/posed_model.h"
#include "tests/unit/world/glb_builder.h"

namespace camrig::world::deform_test {
namespace {

double random_signed(std::uint64_t stream, std::uint64_t i) {
    return random_unit(11, stream, i) * 2.0 - 1.0;
}

ModelRef load(const GlbBuilder& glb) {
    auto model = load_model(glb.build(), {}, "test");
    EXPECT_TRUE(model) << (model ? "" : model.error().message);
    return model ? *model : nullptr;
}

TEST(DeformVertices, NormalsOfAStretchedSphereAreThoseOfTheEllipsoid) {
    // Unit sphere points as a skinned mesh, one joint scaled (2, 0.5, 3): normal ~ p / s^2 of the ellipsoid.
    std::vector<float> points;
    for (std::uint64_t i = 0; i < 300; ++i) {
        const auto p = glm::normalize(glm::dvec3(random_signed(i, 1), random_signed(i, 2), random_signed(i, 3)));
        for (glm::length_t c = 0; c < 3; ++c) points.push_back(static_cast<float>(p[c]));
    }
    GlbBuilder glb;
    const int normals = glb.floats(points, "VEC3");
    const int joints = glb.bytes(std::vector<std::uint8_t>(1200, 0), "VEC4");
    std::vector<float> weights;
    for (int i = 0; i < 300; ++i) weights.insert(weights.end(), {1, 0, 0, 0});
    const int weight = glb.floats(weights, "VEC4");
    glb.mesh(points, {{"attributes", {{"NORMAL", normals}, {"JOINTS_0", joints}, {"WEIGHTS_0", weight}}}});
    for (const glm::dvec3 scale : {glm::dvec3(2, 0.5, 3), glm::dvec3(-2, 0.5, 3)}) {
        glb.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}, {{"scale", {scale.x, scale.y, scale.z}}}};
        glb.json["scenes"] = {{{"nodes", {0, 1}}}};
        glb.json["skins"] = {{{"joints", {1}}}};
        const auto model = load(glb);
        PosedModel pose;
        pose_model(*model, {}, pose);
        const Primitive& primitive = model->meshes[0].primitives[0];
        std::vector<glm::vec3> p(primitive.positions.size()), n(p.size());
        deform_vertices(*model, pose, 0, primitive, p, n);
        for (std::size_t i = 0; i < p.size(); ++i) {
            const glm::dvec3 rest(primitive.positions[i]);
            const glm::dvec3 gltf = glm::normalize(rest / scale);  // gradient of the ellipsoid
            const glm::dvec3 expected(gltf.x, -gltf.z, gltf.y);
            const double cosine = glm::dot(glm::dvec3(n[i]), expected);
            ASSERT_GT(cosine, 1.0 - 1e-6) << i;
        }
    }
}

TEST(DeformVertices, MorphTargetsAddTheirShare) {
    GlbBuilder glb;
    const int delta = glb.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    glb.mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{"targets", {{{"POSITION", delta}}}}});
    glb.json["nodes"][0]["weights"] = {0.25};
    const auto model = load(glb);
    EXPECT_TRUE(is_deformed(*model, 0));
    PosedModel pose;
    pose_model(*model, {}, pose);
    std::vector<glm::vec3> p(3), n(3);
    deform_vertices(*model, pose, 0, model->meshes[0].primitives[0], p, n);
    EXPECT_EQ(p[1], glm::vec3(1, -0.25f, 0));
}

TEST(DeformVertices, FlatNormalsAreThoseOfTheMovedTriangle) {
    GlbBuilder glb;
    const int delta = glb.floats({0, 0, 0, 0, 0, 0, 0, -1, 1}, "VEC3");  // the third corner, from y to z
    glb.mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{"targets", {{{"POSITION", delta}}}}});
    glb.json["nodes"][0]["weights"] = {1.0};
    const auto model = load(glb);
    PosedModel pose;
    pose_model(*model, {}, pose);
    std::vector<glm::vec3> p(3), n(3);
    deform_vertices(*model, pose, 0, model->meshes[0].primitives[0], p, n);
    for (const glm::vec3& normal : n) EXPECT_EQ(normal, glm::vec3(0, 0, -1)) << "of file axes 0, -1, 0";
}

/// Random vertices on `joints` moved joints, each vertex with up to four of them.
ModelRef random_skin(int vertices, int joints) {
    std::vector<float> points, weights;
    std::vector<std::uint16_t> indices;
    for (std::uint64_t v = 0; v < static_cast<std::uint64_t>(vertices); ++v) {
        for (std::uint64_t c = 0; c < 3; ++c) points.push_back(static_cast<float>(random_signed(v, c)));
        for (std::uint64_t i = 0; i < 4; ++i) {
            indices.push_back(static_cast<std::uint16_t>(random_bits(5, v, i) % static_cast<std::uint64_t>(joints)));
            weights.push_back(i <= v % 4 ? static_cast<float>(random_unit(6, v, i)) : 0.0f);
        }
    }
    GlbBuilder glb;
    const int normals = glb.floats(points, "VEC3"), j = glb.shorts(indices, "VEC4"), w = glb.floats(weights, "VEC4");
    glb.mesh(points, {{"attributes", {{"NORMAL", normals}, {"JOINTS_0", j}, {"WEIGHTS_0", w}}}});
    glb.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {100, 100, 100}}}};
    std::vector<int> roots = {0}, skin;
    std::vector<float> inverse_bind;
    for (int joint = 1; joint <= joints; ++joint) {
        const auto at = [&](std::uint64_t i) { return random_signed(static_cast<std::uint64_t>(joint) + 1000000, i); };
        glb.json["nodes"].push_back({{"translation", {at(0), at(1), at(2)}},
                                     {"rotation", {at(3), at(4), at(5), at(6)}},
                                     {"scale", {1.5 + at(7), 1.5 + at(8), 1.5 + at(9)}}});
        roots.push_back(joint);
        skin.push_back(joint);
        for (int i = 0; i < 16; ++i)
            inverse_bind.push_back(i % 5 == 0 ? 1.0f : i >= 12 && i < 15 ? static_cast<float>(at(10 + i)) : 0.0f);
    }
    glb.json["scenes"] = {{{"nodes", roots}}};
    const int matrices = glb.floats(inverse_bind, "MAT4");
    glb.json["skins"] = {{{"joints", skin}, {"inverseBindMatrices", matrices}}};
    return load(glb);
}

TEST(DeformVertices, SomeAreAsAll) {
    const auto model = random_skin(101, 7);
    PosedModel pose;
    pose_model(*model, {}, pose);
    const Primitive& primitive = model->meshes[0].primitives[0];
    const std::vector<std::uint32_t> which{0, 3, 4, 5, 50, 77, 99, 100};
    for (const std::size_t count : {which.size(), std::size_t{5}, std::size_t{1}}) {
        const glm::vec3 untouched(7.0f);
        std::vector<glm::vec3> p(101, untouched), n(101, untouched), all_p(101), all_n(101);
        deform_vertices(*model, pose, 0, primitive, all_p, all_n);
        deform_vertices(*model, pose, 0, primitive, p, n, std::span(which).first(count));
        for (std::uint32_t v = 0; v < 101; ++v) {
            const bool is_asked = std::ranges::find(which.begin(), which.begin() + static_cast<long>(count), v) !=
                                  which.begin() + static_cast<long>(count);
            ASSERT_EQ(p[v], is_asked ? all_p[v] : untouched) << v;
            ASSERT_EQ(n[v], is_asked ? all_n[v] : untouched) << v;
        }
    }
}

TEST(DeformVertices, SkinningAgreesWithTheFormulaInDouble) {
    const auto model = random_skin(2000, 40);
    PosedModel pose;
    pose_model(*model, {}, pose);
    const Primitive& primitive = model->meshes[0].primitives[0];
    std::vector<glm::vec3> p(primitive.positions.size()), n(p.size());
    deform_vertices(*model, pose, 0, primitive, p, n);
    for (std::size_t v = 0; v < p.size(); ++v) {
        glm::dmat4 matrix(0.0);
        for (glm::length_t i = 0; i < 4; ++i) {
            const std::size_t joint = primitive.joints[v][i];
            const auto node = static_cast<std::size_t>(model->skins[0].joints[joint]);
            matrix += static_cast<double>(primitive.weights[v][i]) * pose.model_from_node[node] *
                      model->skins[0].inverse_bind[joint];
        }
        const glm::dvec3 expected(matrix * glm::dvec4(primitive.positions[v], 1.0));
        ASSERT_LT(glm::distance(glm::dvec3(p[v]), expected), 3e-6) << v;
        const glm::dmat3 linear(matrix);
        if (std::abs(glm::determinant(linear)) < 1e-2) continue;  // where a normal's direction is not well defined
        const glm::dvec3 normal =
            glm::normalize(glm::transpose(glm::inverse(linear)) * glm::dvec3(primitive.normals[v]));
        ASSERT_LT(glm::distance(glm::dvec3(n[v]), normal), 1e-4) << v;
    }
}

}  // namespace
}  // namespace camrig::world::deform_test
