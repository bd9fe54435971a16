#include "core/render/software/mesh_neighbors.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace camrig::render::software {
namespace {

/// The first vertex that is the same, for each one.
std::vector<std::uint32_t> welded(const world::Primitive& primitive) {
    std::vector<std::uint32_t> same(primitive.positions.size()), order(same.size());
    std::iota(same.begin(), same.end(), 0u);
    if (!primitive.targets.empty()) return same;
    order = same;
    const auto compare = [&](std::uint32_t a, std::uint32_t b) {
        int sign = 0;
        const auto by = [&]<typename V>(const std::vector<V>& values) {
            for (glm::length_t i = 0; sign == 0 && !values.empty() && i < V::length(); ++i)
                sign = (values[a][i] > values[b][i]) - (values[a][i] < values[b][i]);
        };
        by(primitive.positions);
        by(primitive.normals);
        by(primitive.colors);
        by(primitive.joints);
        by(primitive.weights);
        return sign;
    };
    std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
        const int sign = compare(a, b);
        return sign != 0 ? sign < 0 : a < b;
    });
    for (std::size_t i = 1; i < order.size(); ++i)
        if (compare(order[i - 1], order[i]) == 0) same[order[i]] = same[order[i - 1]];
    return same;
}

struct MeshEdge {
    std::uint32_t low, high;  ///< vertices
    bool is_rising;           ///< the triangle goes from the low to the high one
    std::uint32_t triangle, corner;
};

}  // namespace

MeshNeighbors neighbors_of(const scene::TriangleCorners& triangles, const world::Primitive& primitive) {
    const std::vector<std::uint32_t> same = welded(primitive);
    MeshNeighbors neighbors(triangles[0].size(), {-1, -1, -1});
    std::vector<MeshEdge> edges;
    edges.reserve(3 * neighbors.size());
    for (std::uint32_t i = 0; i < neighbors.size(); ++i) {
        for (std::uint32_t c = 0; c < 3; ++c) {
            const std::uint32_t from = same[triangles[(c + 1) % 3][i]], to = same[triangles[(c + 2) % 3][i]];
            edges.push_back({std::min(from, to), std::max(from, to), from < to, i, c});
        }
    }
    const auto place = [](const MeshEdge& e) { return std::pair(e.low, e.high); };
    std::ranges::sort(edges, {}, [&](const MeshEdge& e) { return std::tuple(e.low, e.high, e.triangle, e.corner); });
    for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
        while (end < edges.size() && place(edges[end]) == place(edges[i])) ++end;
        const MeshEdge &a = edges[i], &b = edges[end - 1];
        if (end - i != 2 || a.is_rising == b.is_rising) continue;
        neighbors[a.triangle][a.corner] = static_cast<std::int32_t>(b.triangle);
        neighbors[b.triangle][b.corner] = static_cast<std::int32_t>(a.triangle);
    }
    return neighbors;
}

}  // namespace camrig::render::software
