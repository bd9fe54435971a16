#include <algorithm>
#include <cmath>

#include "core/base/result.h"
#include "core/world/posed_model.h"

// Skinning and morphing on the CPU, in single precision with matrices made in double: models are metres across, so
// float is good to a micrometre, and the arithmetic is the same on every x86-64 machine.
namespace camrig::world {
namespace {

// Four floats as one SSE register; GCC and clang both know this form, and -O2 would not vectorise by itself. Joints are
// blended row by row, then four vertices at a time are transformed, one in each lane. For 40 000 vertices of four
// joints each that is 0.96 ms, one vertex at a time with the same compiler options 1.07 ms (AMD EPYC, one thread, best
// of 400).
using Float4 = float __attribute__((vector_size(16)));
constexpr std::size_t lane_count = 4;

/// The upper three rows of an affine matrix.
struct Rows {
    Float4 row[3];
};

/// One vector in each lane.
struct Vector4 {
    Float4 x, y, z;
};

/// One affine matrix in each lane: three directions and the translation.
struct Matrix4 {
    Vector4 column[4];
};

Rows to_float(const glm::dmat4& m) {
    Rows out{};
    for (glm::length_t r = 0; r < 3; ++r)
        for (glm::length_t c = 0; c < 4; ++c) out.row[r][c] = static_cast<float>(m[c][r]);
    return out;
}

Rows blend(std::span<const Rows> joints, const glm::u16vec4& index, const glm::vec4& weight) {
    Rows out;
    const Rows& first = joints[index.x];
    for (int r = 0; r < 3; ++r) out.row[r] = first.row[r] * weight.x;
    // Weights fall: the loader put the strongest first.
    for (glm::length_t i = 1; i < 4 && weight[i] > 0.0f; ++i) {
        const Rows& joint = joints[index[i]];
        for (int r = 0; r < 3; ++r) out.row[r] += joint.row[r] * weight[i];
    }
    return out;
}

Matrix4 transpose(const Rows (&m)[lane_count]) {
    Matrix4 out;
    for (int r = 0; r < 3; ++r) {
        const Float4 a = __builtin_shufflevector(m[0].row[r], m[1].row[r], 0, 4, 1, 5);
        const Float4 b = __builtin_shufflevector(m[2].row[r], m[3].row[r], 0, 4, 1, 5);
        const Float4 c = __builtin_shufflevector(m[0].row[r], m[1].row[r], 2, 6, 3, 7);
        const Float4 d = __builtin_shufflevector(m[2].row[r], m[3].row[r], 2, 6, 3, 7);
        const Float4 columns[4] = {__builtin_shufflevector(a, b, 0, 1, 4, 5), __builtin_shufflevector(a, b, 2, 3, 6, 7),
                                   __builtin_shufflevector(c, d, 0, 1, 4, 5),
                                   __builtin_shufflevector(c, d, 2, 3, 6, 7)};
        for (int k = 0; k < 4; ++k)
            (r == 0 ? out.column[k].x : r == 1 ? out.column[k].y : out.column[k].z) = columns[k];
    }
    return out;
}

Vector4 cross(const Vector4& a, const Vector4& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Float4 dot(const Vector4& a, const Vector4& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vector4 operator*(const Vector4& a, Float4 b) {
    return {a.x * b, a.y * b, a.z * b};
}
Vector4 operator+(const Vector4& a, const Vector4& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}

Vector4 transform_point(const Matrix4& m, const Vector4& p) {
    return m.column[0] * p.x + m.column[1] * p.y + m.column[2] * p.z + m.column[3];
}

/// By the cofactor matrix: det * inverse transpose, defined for singular matrices too. Its direction counts, with the
/// sign of the determinant taken out; a normal of no length becomes +z.
Vector4 transform_normal(const Matrix4& m, const Vector4& n) {
    const Vector4 yz = cross(m.column[1], m.column[2]);
    const Vector4 v = yz * n.x + cross(m.column[2], m.column[0]) * n.y + cross(m.column[0], m.column[1]) * n.z;
    const Float4 length2 = dot(v, v), determinant = dot(m.column[0], yz);
    Float4 length;
    for (std::size_t i = 0; i < lane_count; ++i) length[i] = std::sqrt(length2[i]);
    const Float4 one = {1.0f, 1.0f, 1.0f, 1.0f}, zero = {};
    const Float4 scale = (determinant < zero ? -one : one) / length;
    const auto good = length2 > zero;
    return {good ? v.x * scale : zero, good ? v.y * scale : zero, good ? v.z * scale : one};
}

/// What is transformed, and where to.
struct Vertices {
    std::span<const glm::vec3> positions, normals;  ///< no normals: all +z
    std::span<glm::vec3> to_positions, to_normals;
};

/// of(i): a vector.
template <typename Of>
Vector4 four(const Of& of) {
    const glm::vec3 a = of(0), b = of(1), c = of(2), d = of(3);
    return {Float4{a.x, b.x, c.x, d.x}, Float4{a.y, b.y, c.y, d.y}, Float4{a.z, b.z, c.z, d.z}};
}

/// vertex_of(i): the vertex to transform as number i of `count`; rows_of(vertex): its matrix.
template <typename VertexOf, typename RowsOf>
void transform(const Vertices& vertices, std::size_t count, const VertexOf& vertex_of, const RowsOf& rows_of) {
    for (std::size_t first = 0; first < count; first += lane_count) {
        std::size_t at[lane_count];
        for (std::size_t i = 0; i < lane_count; ++i) at[i] = vertex_of(std::min(first + i, count - 1));
        Rows rows[lane_count];
        for (std::size_t i = 0; i < lane_count; ++i) rows[i] = rows_of(at[i]);
        const Matrix4 matrix = transpose(rows);
        const Vector4 p = transform_point(matrix, four([&](std::size_t i) { return vertices.positions[at[i]]; }));
        const Vector4 n = transform_normal(matrix, four([&](std::size_t i) {
                                               return vertices.normals.empty() ? glm::vec3(0.0f, 0.0f, 1.0f)
                                                                               : vertices.normals[at[i]];
                                           }));
        // The last one may come more than once, with the same values.
        for (std::size_t i = 0; i < lane_count; ++i) {
            vertices.to_positions[at[i]] = {p.x[i], p.y[i], p.z[i]};
            vertices.to_normals[at[i]] = {n.x[i], n.y[i], n.z[i]};
        }
    }
}

template <typename RowsOf>
void transform(const Vertices& vertices, std::optional<std::span<const std::uint32_t>> which, const RowsOf& rows_of) {
    if (!which) {
        transform(vertices, vertices.positions.size(), [](std::size_t i) { return i; }, rows_of);
    } else {
        transform(vertices, which->size(), [&](std::size_t i) -> std::size_t { return (*which)[i]; }, rows_of);
    }
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

bool deforming_mirrors(const Model& model, const PosedModel& pose, int node, const Primitive& primitive) {
    const int skin = model.nodes[static_cast<std::size_t>(node)].skin;
    if (skin < 0 || primitive.joints.empty())
        return glm::determinant(glm::dmat3(pose.model_from_node[static_cast<std::size_t>(node)])) < 0.0;
    const Skin& of = model.skins[static_cast<std::size_t>(skin)];
    glm::dmat3 sum(0.0);
    for (glm::length_t i = 0; i < 4; ++i) {
        const std::size_t j = primitive.joints.front()[i];
        const glm::dmat4& joint = pose.model_from_node[static_cast<std::size_t>(of.joints[j])];
        sum += double{primitive.weights.front()[i]} * glm::dmat3(joint * of.inverse_bind[j]);
    }
    return glm::determinant(sum) < 0.0;
}

void deform_vertices(const Model& model, const PosedModel& pose, int node, const Primitive& primitive,
                     std::span<glm::vec3> positions, std::span<glm::vec3> normals,
                     std::optional<std::span<const std::uint32_t>> which) {
    const auto index = static_cast<std::size_t>(node);
    CHECK(positions.size() == primitive.positions.size() && normals.size() == positions.size());
    Vertices vertices{primitive.positions, primitive.normals, positions, normals};
    if (!primitive.targets.empty()) {
        morph(primitive, pose.morph_weights[index], positions, normals);
        vertices.positions = positions;
        vertices.normals = normals;
    }
    const Node& n = model.nodes[index];
    if (n.skin < 0 || primitive.joints.empty()) {
        const Rows rows = to_float(pose.model_from_node[index]);
        return transform(vertices, which, [&](std::size_t) { return rows; });
    }
    // A skinned mesh is placed by its joints alone; its node's own transform does not count (glTF 2.0, 3.7.3.3).
    static thread_local std::vector<Rows> joints;
    const Skin& skin = model.skins[static_cast<std::size_t>(n.skin)];
    joints.resize(skin.joints.size());
    for (std::size_t j = 0; j < joints.size(); ++j) {
        const auto joint = static_cast<std::size_t>(skin.joints[j]);
        joints[j] = to_float(pose.model_from_node[joint] * skin.inverse_bind[j]);
    }
    transform(vertices, which, [&](std::size_t v) { return blend(joints, primitive.joints[v], primitive.weights[v]); });
}

}  // namespace camrig::world
