#include "core/bake/unwrap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "core/bake/rect_packing.h"

namespace camrig::bake {
namespace {

using Corners = std::array<std::uint32_t, 3>;

/// Normals of a chart's triangles lean at most so far from the chart's: cos(37 deg).
constexpr double least_cosine = 0.8;
/// Around a chart, so that no texel that it is filtered from is nearer to another one (LightMap).
constexpr int padding = 1;

struct Mesh {
    std::vector<Corners> triangles;   ///< vertices of the file
    std::vector<glm::dvec3> normals;  ///< unit; 0 of triangles without an area
    std::vector<double> areas;
    std::vector<std::vector<std::size_t>> neighbors;  ///< over edges, whatever the vertices carry
};

Mesh mesh_of(const world::Primitive& primitive) {
    Mesh mesh;
    const auto less = [](const glm::vec3& a, const glm::vec3& b) {
        return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    };
    std::map<glm::vec3, std::uint32_t, decltype(less)> places(less);
    std::vector<std::uint32_t> place_of;
    for (const glm::vec3& position : primitive.positions)
        place_of.push_back(places.try_emplace(position, static_cast<std::uint32_t>(places.size())).first->second);
    std::map<std::array<std::uint32_t, 2>, std::vector<std::size_t>> edges;
    for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
        const Corners corners{primitive.indices[i], primitive.indices[i + 1], primitive.indices[i + 2]};
        const glm::dvec3 a(primitive.positions[corners[0]]), b(primitive.positions[corners[1]]),
            c(primitive.positions[corners[2]]);
        const glm::dvec3 across = glm::cross(b - a, c - a);
        const double length = glm::length(across);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = place_of[corners[k]], to = place_of[corners[(k + 1) % 3]];
            edges[{std::min(from, to), std::max(from, to)}].push_back(mesh.triangles.size());
        }
        mesh.triangles.push_back(corners);
        mesh.normals.push_back(length > 0.0 ? across / length : glm::dvec3(0.0));
        mesh.areas.push_back(0.5 * length);
    }
    mesh.neighbors.resize(mesh.triangles.size());
    for (const auto& [edge, sides] : edges) {
        // Where more than two meet nobody can say which go on in each other.
        if (sides.size() != 2) continue;
        mesh.neighbors[sides[0]].push_back(sides[1]);
        mesh.neighbors[sides[1]].push_back(sides[0]);
    }
    return mesh;
}

/// Which triangles are of one chart: grown from the largest that is left over edges, as long as the normals fit.
std::vector<std::vector<std::size_t>> charts_of(const Mesh& mesh) {
    std::vector<std::size_t> by_area(mesh.triangles.size());
    std::iota(by_area.begin(), by_area.end(), std::size_t{0});
    std::ranges::stable_sort(by_area, [&](std::size_t a, std::size_t b) { return mesh.areas[a] > mesh.areas[b]; });
    std::vector<bool> is_taken(mesh.triangles.size());
    std::vector<std::vector<std::size_t>> charts;
    for (const std::size_t seed : by_area) {
        if (is_taken[seed]) continue;
        is_taken[seed] = true;
        std::vector<std::size_t>& chart = charts.emplace_back(1, seed);
        for (std::size_t at = 0; at < chart.size(); ++at) {
            for (const std::size_t next : mesh.neighbors[chart[at]]) {
                const bool is_flat = mesh.areas[next] == 0.0;
                if (is_taken[next] || (!is_flat && glm::dot(mesh.normals[next], mesh.normals[seed]) < least_cosine))
                    continue;
                is_taken[next] = true;
                chart.push_back(next);
            }
        }
    }
    return charts;
}

struct Flat {
    std::vector<std::uint32_t> vertices;  ///< of the file, each once
    std::vector<glm::dvec2> places;       ///< of these, from 0 on
    std::vector<Corners> triangles;       ///< into vertices
    glm::dvec2 extent{0.0};
};

/// The chart along its normal, turned so that its box is small.
Flat flattened(const world::Primitive& primitive, const Mesh& mesh, std::span<const std::size_t> chart, double scale) {
    Flat flat;
    std::map<std::uint32_t, std::uint32_t> own;
    for (const std::size_t triangle : chart) {
        Corners corners{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = mesh.triangles[triangle][k];
            const auto [at, is_new] = own.try_emplace(vertex, static_cast<std::uint32_t>(flat.vertices.size()));
            if (is_new) flat.vertices.push_back(vertex);
            corners[k] = at->second;
        }
        flat.triangles.push_back(corners);
    }
    const glm::dvec3 n = mesh.normals[chart.front()];
    const glm::dvec3 helper = std::abs(n.z) < 0.9 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(1.0, 0.0, 0.0);
    const glm::dvec3 right = glm::dot(n, n) > 0.0 ? glm::normalize(glm::cross(helper, n)) : glm::dvec3(1.0, 0.0, 0.0);
    const glm::dvec3 down = glm::dot(n, n) > 0.0 ? glm::cross(n, right) : glm::dvec3(0.0, 1.0, 0.0);
    std::vector<glm::dvec2> straight;
    for (const std::uint32_t vertex : flat.vertices) {
        const glm::dvec3 p = scale * glm::dvec3(primitive.positions[vertex]);
        straight.emplace_back(glm::dot(p, right), glm::dot(p, down));
    }
    double smallest = 0.0;
    for (int step = 0; step < 12; ++step) {
        const double angle = step * (1.5707963267948966 / 12), c = std::cos(angle), s = std::sin(angle);
        std::vector<glm::dvec2> turned;
        glm::dvec2 low(1e30), high(-1e30);
        for (const glm::dvec2& p : straight) {
            const glm::dvec2 q(c * p.x + s * p.y, c * p.y - s * p.x);
            low = glm::min(low, q);
            high = glm::max(high, q);
            turned.push_back(q);
        }
        const glm::dvec2 extent = high - low;
        const double size = (extent.x + 2.0) * (extent.y + 2.0);
        // A box that is smaller by a rounding is no better than the straight one.
        if (step > 0 && size > 0.98 * smallest) continue;
        smallest = size;
        for (glm::dvec2& q : turned) q -= low;
        flat.places = std::move(turned);
        flat.extent = extent;
    }
    return flat;
}

}  // namespace

world::BakedPrimitive unwrap(const world::Primitive& primitive, double texels_per_unit) {
    world::BakedPrimitive made;
    if (primitive.topology != world::Topology::triangles) return made;
    const Mesh mesh = mesh_of(primitive);
    const std::vector<std::vector<std::size_t>> charts = charts_of(mesh);
    std::vector<Flat> flats;
    std::optional<PackedRects> packed;
    // One that would fill the map leaves room for others.
    constexpr double most = max_chart_side - 4, wanted = 0.5 * most, fewer = 0.7;
    constexpr int most_tries = 64;
    for (int i = 0; i < most_tries && !packed; ++i) {
        flats.clear();
        double side = 0.0;
        std::vector<ImageSize> sizes;
        for (const std::vector<std::size_t>& chart : charts) {
            flats.push_back(flattened(primitive, mesh, chart, texels_per_unit));
            const glm::dvec2 extent = flats.back().extent;
            if (!std::isfinite(extent.x) || !std::isfinite(extent.y)) return made;
            side = std::max({side, extent.x, extent.y});
        }
        if (side >= most) {
            texels_per_unit *= wanted / side;
            continue;
        }
        // From the middle of its first texel to that of its last.
        for (const Flat& flat : flats)
            sizes.push_back({static_cast<int>(std::ceil(flat.extent.x)) + 1 + 2 * padding,
                             static_cast<int>(std::ceil(flat.extent.y)) + 1 + 2 * padding});
        packed = pack_tightly(sizes, world::BakedPrimitive::max_side);
        texels_per_unit *= fewer;
    }
    if (!packed) return made;
    made.size = packed->area;
    made.indices.resize(3 * mesh.triangles.size());  // in the order of the file
    for (std::size_t i = 0; i < flats.size(); ++i) {
        const auto first = static_cast<std::uint32_t>(made.vertices.size());
        const glm::dvec2 origin = glm::dvec2(packed->places[i]) + (padding + 0.5);
        for (std::size_t k = 0; k < flats[i].vertices.size(); ++k) {
            made.vertices.push_back(flats[i].vertices[k]);
            made.coordinates.emplace_back(origin + flats[i].places[k]);
        }
        for (std::size_t t = 0; t < charts[i].size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) made.indices[3 * charts[i][t] + k] = first + flats[i].triangles[t][k];
    }
    return made;
}

}  // namespace camrig::bake
