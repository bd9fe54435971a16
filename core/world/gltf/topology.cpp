#include "core/world/gltf/topology.h"

#include <numeric>

namespace camrig::world::gltf {
namespace {

using Indices = std::vector<std::uint32_t>;

Indices strip_to_list(const Indices& in) {
    Indices out;
    out.reserve(in.size() * 3);
    for (std::size_t i = 0; i + 2 < in.size(); ++i) {
        const std::size_t odd = i % 2;
        out.insert(out.end(), {in[i], in[i + 1 + odd], in[i + 2 - odd]});
    }
    return out;
}

Indices fan_to_list(const Indices& in) {
    Indices out;
    out.reserve(in.size() * 3);
    for (std::size_t i = 0; i + 2 < in.size(); ++i) out.insert(out.end(), {in[i + 1], in[i + 2], in[0]});
    return out;
}

Indices line_strip_to_list(const Indices& in, bool closed) {
    Indices out;
    out.reserve(in.size() * 2);
    for (std::size_t i = 0; i + 1 < in.size(); ++i) out.insert(out.end(), {in[i], in[i + 1]});
    if (closed && in.size() > 1) out.insert(out.end(), {in.back(), in.front()});
    return out;
}

template <typename T>
std::vector<T> gather(const std::vector<T>& from, const Indices& indices) {
    std::vector<T> out;
    if (from.empty()) return out;
    out.reserve(indices.size());
    for (const std::uint32_t i : indices) out.push_back(from[i]);
    return out;
}

}  // namespace

Topology topology_of(Mode mode) {
    if (mode == Mode::points) return Topology::points;
    return mode < Mode::triangles ? Topology::lines : Topology::triangles;
}

Indices to_list(Mode mode, Indices indices) {
    switch (mode) {
        case Mode::points:
            return indices;
        case Mode::lines:
            indices.resize(indices.size() / 2 * 2);
            return indices;
        case Mode::line_loop:
            return line_strip_to_list(indices, true);
        case Mode::line_strip:
            return line_strip_to_list(indices, false);
        case Mode::triangles:
            indices.resize(indices.size() / 3 * 3);
            return indices;
        case Mode::triangle_strip:
            return strip_to_list(indices);
        case Mode::triangle_fan:
            return fan_to_list(indices);
    }
    return indices;
}

namespace {

/// Of triangles that share no corners.
std::vector<glm::vec3> flat_normals(const std::vector<glm::vec3>& positions) {
    std::vector<glm::vec3> normals(positions.size());
    for (std::size_t i = 0; i + 2 < positions.size(); i += 3) {
        const glm::dvec3 a(positions[i]), b(positions[i + 1]), c(positions[i + 2]);
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        const double length = glm::length(normal);
        const glm::vec3 unit = length > 0.0 ? glm::vec3(normal / length) : glm::vec3(0.0f, 1.0f, 0.0f);
        for (std::size_t corner = 0; corner < 3; ++corner) normals[i + corner] = unit;
    }
    return normals;
}

}  // namespace

void make_flat(Primitive& primitive) {
    const Indices& indices = primitive.indices;
    primitive.positions = gather(primitive.positions, indices);
    for (auto& coords : primitive.texcoords) coords = gather(coords, indices);
    primitive.colors = gather(primitive.colors, indices);
    primitive.joints = gather(primitive.joints, indices);
    primitive.weights = gather(primitive.weights, indices);
    for (MorphTarget& target : primitive.targets) target.positions = gather(target.positions, indices);
    primitive.tangents.clear();  // meaningless without the file's own normals
    std::iota(primitive.indices.begin(), primitive.indices.end(), 0u);

    primitive.normals = flat_normals(primitive.positions);
    // Of each target by itself (glTF 2.0, 3.7.2.2); several at once are added, as file's normals are.
    for (MorphTarget& target : primitive.targets) {
        target.normals.clear();
        if (target.positions.empty()) continue;
        std::vector<glm::vec3> moved(primitive.positions);
        for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += target.positions[i];
        target.normals = flat_normals(moved);
        for (std::size_t i = 0; i < moved.size(); ++i) target.normals[i] -= primitive.normals[i];
    }
}

}  // namespace camrig::world::gltf
