#include "core/render/scene/detail_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>

namespace camrig::render::scene {
namespace {

constexpr int rings = 40, sectors = 64;

/// A closed skinned sphere of radius 1.
world::Primitive sphere() {
    world::Primitive mesh;
    mesh.positions.emplace_back(0.0f, 0.0f, 1.0f);
    for (int ring = 1; ring < rings; ++ring) {
        for (int sector = 0; sector < sectors; ++sector) {
            const double polar = std::numbers::pi * ring / rings, around = 2.0 * std::numbers::pi * sector / sectors;
            mesh.positions.emplace_back(
                glm::dvec3(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar)));
        }
    }
    mesh.positions.emplace_back(0.0f, 0.0f, -1.0f);
    const auto at = [](int ring, int sector) {
        return static_cast<std::uint32_t>(1 + (ring - 1) * sectors + sector % sectors);
    };
    const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
    for (int s = 0; s < sectors; ++s) {
        mesh.indices.insert(mesh.indices.end(), {0, at(1, s), at(1, s + 1)});
        for (int ring = 1; ring + 1 < rings; ++ring) {
            mesh.indices.insert(mesh.indices.end(), {at(ring, s), at(ring + 1, s), at(ring + 1, s + 1)});
            mesh.indices.insert(mesh.indices.end(), {at(ring, s), at(ring + 1, s + 1), at(ring, s + 1)});
        }
        mesh.indices.insert(mesh.indices.end(), {last, at(rings - 1, s + 1), at(rings - 1, s)});
    }
    mesh.joints.assign(mesh.positions.size(), glm::u16vec4(0));
    mesh.weights.assign(mesh.positions.size(), glm::vec4(1.0f, 0.0f, 0.0f, 0.0f));
    return mesh;
}

/// How far inside the unit sphere the flat triangles get, sampled on a fine grid in each: the distance of the surfaces.
double deepest(const world::Primitive& mesh, const std::vector<std::uint32_t>& indices) {
    constexpr int steps = 16;
    double nearest = 1.0;
    for (std::size_t t = 0; t < indices.size(); t += 3) {
        const glm::dvec3 a(mesh.positions[indices[t]]), b(mesh.positions[indices[t + 1]]),
            c(mesh.positions[indices[t + 2]]);
        for (int i = 0; i <= steps; ++i)
            for (int j = 0; i + j <= steps; ++j)
                nearest =
                    std::min(nearest, glm::length(a + (b - a) * (i / double{steps}) + (c - a) * (j / double{steps})));
    }
    return 1.0 - nearest;
}

TEST(DetailLevels, HaveFewerTrianglesAndStateTheirError) {
    const world::Primitive mesh = sphere();
    const auto levels = make_detail_levels(mesh);
    ASSERT_GE(levels.size(), 3u);
    std::size_t triangles = mesh.indices.size();
    float error = 0.0f;
    const double own = deepest(mesh, mesh.indices);
    for (const DetailLevel& level : levels) {
        EXPECT_LT(level.indices.size(), triangles);
        EXPECT_GT(level.error, error);
        EXPECT_LT(std::ranges::max(level.indices), mesh.positions.size());
        EXPECT_LE(deepest(mesh, level.indices) - own, 2.0 * level.error) << level.indices.size() / 3 << " triangles";
        triangles = level.indices.size();
        error = level.error;
    }
}

TEST(DetailLevels, AreForLargeSkinnedTriangleMeshesOnly) {
    world::Primitive rigid = sphere();
    rigid.joints.clear();
    EXPECT_TRUE(make_detail_levels(rigid).empty()) << "measured on: drawn as it is";
    world::Primitive morphed = sphere();
    morphed.targets.resize(1);
    EXPECT_TRUE(make_detail_levels(morphed).empty());
    world::Primitive small = sphere();
    small.indices.resize(300);
    EXPECT_TRUE(make_detail_levels(small).empty());
}

TEST(DetailLevels, ErrorInThePictureIsNeverLessThanAnyDisplacementShows) {
    const ViewTransform view = make_view_transform({}, {640, 480}, {500.0, 510.0, 319.5, 239.5}, 0.05, 0.0);
    // A box of 0.6 x 1.8 x 0.4 m, turned, to the right of the middle and below it.
    const world::Box box{{-0.3f, -0.9f, -0.2f}, {0.3f, 0.9f, 0.2f}};
    glm::dmat4 optical_from_local(glm::mat3_cast(glm::angleAxis(0.7, glm::normalize(glm::dvec3(0.3, 1.0, 0.2)))));
    optical_from_local[3] = {1.2, -0.8, 3.0, 1.0};
    const double error = 0.01;
    const double bound = detail_error_px(view, optical_from_local, box, error);
    const auto project = [](const glm::dvec3& p) { return glm::dvec2(500.0 * p.x / p.z, 510.0 * p.y / p.z); };
    double largest = 0.0;
    for (int i = 0; i < 8 * 2000; ++i) {
        // Corners of the box that is smaller by the error all around, displaced any way: a spiral over directions.
        const double z = 1.0 - 2.0 * (i / 8 + 0.5) / 2000.0, angle = 2.399963 * (i / 8);
        const glm::dvec3 way(std::sqrt(1.0 - z * z) * std::cos(angle), std::sqrt(1.0 - z * z) * std::sin(angle), z);
        const glm::dvec4 local((i & 1 ? 1 : -1) * (0.3 - error), (i & 2 ? 1 : -1) * (0.9 - error),
                               (i & 4 ? 1 : -1) * (0.2 - error), 1.0);
        const glm::dvec3 point(optical_from_local * local);
        largest = std::max(largest, glm::distance(project(point), project(point + error * way)));
    }
    EXPECT_LE(largest, bound);
    EXPECT_GT(largest, 0.85 * bound) << "no more than the box needs";
    optical_from_local[3] = {0.0, 0.0, 0.3, 1.0};
    EXPECT_EQ(detail_error_px(view, optical_from_local, box, error), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace camrig::render::scene
