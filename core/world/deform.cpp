#include <algorithm>
#include <cmath>

#include "core/base/result.h"
#include "core/world/posed_model.h"

// Skinning and morphing on the CPU, in single precision with matrices made in double: models are metres across, so
// float is good to a micrometre, and the arithmetic is the same on every x86-64 machine.
namespace camrig {
namespace {

// Four floats as one SSE register; GCC and clang both know this form, and -O2 would not vectorise by itself.
using Float4 = float __attribute__((vector_size(16)));

/// Columns of an affine matrix: three directions and the translation; the fourth lane is not used.
struct Matrix {
    Float4 column[4];
};

Matrix to_float(const glm::dmat4& m) {
    Matrix out{};
    for (glm::length_t c = 0; c < 4; ++c)
        for (glm::length_t r = 0; r < 4; ++r) out.column[c][r] = static_cast<float>(m[c][r]);
    return out;
}

Float4 cross(Float4 a, Float4 b) {
    const Float4 a_yzx = __builtin_shufflevector(a, a, 1, 2, 0, 3);
    const Float4 b_yzx = __builtin_shufflevector(b, b, 1, 2, 0, 3);
    const Float4 zxy = a * b_yzx - a_yzx * b;
    return __builtin_shufflevector(zxy, zxy, 1, 2, 0, 3);
}

float dot3(Float4 a, Float4 b) {
    const Float4 p = a * b;
    return p[0] + p[1] + p[2];
}

/// The cofactor matrix is det * inverse transpose, defined for singular matrices too; normals need its direction with
/// the sign of the determinant taken out.
struct NormalMatrix {
    Float4 column[3];
    explicit NormalMatrix(const Matrix& m)
        : column{cross(m.column[1], m.column[2]), cross(m.column[2], m.column[0]), cross(m.column[0], m.column[1])} {
        if (dot3(m.column[0], column[0]) < 0.0f)
            for (Float4& c : column) c = -c;
    }
};

glm::vec3 transform(const Matrix& m, const glm::vec3& p) {
    const Float4 out = m.column[0] * p.x + m.column[1] * p.y + m.column[2] * p.z + m.column[3];
    return {out[0], out[1], out[2]};
}

glm::vec3 transform(const NormalMatrix& m, const glm::vec3& n) {
    const Float4 out = m.column[0] * n.x + m.column[1] * n.y + m.column[2] * n.z;
    const float length2 = dot3(out, out);
    if (!(length2 > 0.0f)) return {0.0f, 0.0f, 1.0f};
    const float scale = 1.0f / std::sqrt(length2);
    return {out[0] * scale, out[1] * scale, out[2] * scale};
}

Matrix blend(std::span<const Matrix> joints, const glm::u16vec4& index, const glm::vec4& weight) {
    Matrix out;
    const Matrix& first = joints[index.x];
    for (int c = 0; c < 4; ++c) out.column[c] = first.column[c] * weight.x;
    // Weights fall: the loader put the strongest first.
    for (glm::length_t i = 1; i < 4 && weight[i] > 0.0f; ++i) {
        const Matrix& joint = joints[index[i]];
        for (int c = 0; c < 4; ++c) out.column[c] += joint.column[c] * weight[i];
    }
    return out;
}

void morph(const Primitive& primitive, std::span<const float> weights, std::span<glm::vec3> positions,
           std::span<glm::vec3> normals) {
    std::ranges::copy(primitive.positions, positions.begin());
    if (primitive.normals.empty())
        std::ranges::fill(normals, glm::vec3(0.0f, 0.0f, 1.0f));
    else
        std::ranges::copy(primitive.normals, normals.begin());
    const std::size_t count = std::min(weights.size(), primitive.targets.size());
    for (std::size_t t = 0; t < count; ++t) {
        if (weights[t] == 0.0f) continue;
        const MorphTarget& target = primitive.targets[t];
        for (std::size_t v = 0; v < target.positions.size(); ++v) positions[v] += weights[t] * target.positions[v];
        if (primitive.normals.empty()) continue;
        for (std::size_t v = 0; v < target.normals.size(); ++v) normals[v] += weights[t] * target.normals[v];
    }
}

}  // namespace

void deform_vertices(const Model& model, const PosedModel& pose, int node, const Primitive& primitive,
                     std::span<glm::vec3> positions, std::span<glm::vec3> normals) {
    const auto index = static_cast<std::size_t>(node);
    CHECK(positions.size() == primitive.positions.size() && normals.size() == positions.size());
    morph(primitive, pose.morph_weights[index], positions, normals);

    const Node& n = model.nodes[index];
    if (n.skin < 0 || primitive.joints.empty()) {
        const Matrix matrix = to_float(pose.model_from_node[index]);
        const NormalMatrix normal_matrix(matrix);
        for (glm::vec3& p : positions) p = transform(matrix, p);
        for (glm::vec3& v : normals) v = transform(normal_matrix, v);
        return;
    }
    // A skinned mesh is placed by its joints alone; its node's own transform does not count (glTF 2.0, 3.7.3.3).
    static thread_local std::vector<Matrix> joints;
    const Skin& skin = model.skins[static_cast<std::size_t>(n.skin)];
    joints.resize(skin.joints.size());
    for (std::size_t j = 0; j < joints.size(); ++j) {
        const auto joint = static_cast<std::size_t>(skin.joints[j]);
        joints[j] = to_float(pose.model_from_node[joint] * skin.inverse_bind[j]);
    }
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const Matrix matrix = blend(joints, primitive.joints[v], primitive.weights[v]);
        positions[v] = transform(matrix, positions[v]);
        normals[v] = transform(NormalMatrix(matrix), normals[v]);
    }
}

}  // namespace camrig
