#include "core/bake/unwrap.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace camrig::bake {
namespace {

/// A ball whose vertices are shared.
world::Primitive ball(int rings) {
    world::Primitive made;
    const int columns = 2 * rings;
    for (int i = 0; i <= rings; ++i) {
        for (int j = 0; j <= columns; ++j) {
            const double a = std::numbers::pi * i / rings, b = std::numbers::pi * j / rings;
            made.positions.emplace_back(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
        }
    }
    const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (columns + 1) + j); };
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < columns; ++j)
            for (const std::uint32_t index :
                 {at(i, j), at(i + 1, j), at(i, j + 1), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)})
                made.indices.push_back(index);
    return made;
}

world::Primitive random_triangles(std::uint64_t seed, int count) {
    world::Primitive made;
    for (int i = 0; i < 3 * count; ++i) {
        const auto number = static_cast<std::uint64_t>(i);
        made.positions.emplace_back(4.0 * random_unit(seed, number, 0), 4.0 * random_unit(seed, number, 1),
                                    4.0 * random_unit(seed, number, 2));
        made.indices.push_back(static_cast<std::uint32_t>(i));
    }
    return made;
}

/// Triangles that share a vertex of their own are of one chart.
std::vector<std::size_t> chart_of_triangles(const world::BakedPrimitive& cut) {
    std::vector<std::size_t> root(cut.vertices.size());
    for (std::size_t i = 0; i < root.size(); ++i) root[i] = i;
    const auto find = [&](std::size_t i) {
        while (root[i] != i) i = root[i];
        return i;
    };
    for (std::size_t i = 0; i < cut.indices.size(); i += 3)
        for (std::size_t k = 1; k < 3; ++k) root[find(cut.indices[i + k])] = find(cut.indices[i]);
    std::vector<std::size_t> made;
    for (std::size_t i = 0; i < cut.indices.size(); i += 3) made.push_back(find(cut.indices[i]));
    return made;
}

/// No texel that one chart is filtered from is one of another's.
void expect_apart(const world::BakedPrimitive& cut) {
    const std::vector<std::size_t> charts = chart_of_triangles(cut);
    std::map<std::size_t, std::array<glm::vec2, 2>> boxes;
    for (std::size_t i = 0; i < cut.indices.size(); ++i) {
        auto& [low, high] =
            boxes.try_emplace(charts[i / 3], std::array{glm::vec2(1e9f), glm::vec2(-1e9f)}).first->second;
        low = glm::min(low, cut.coordinates[cut.indices[i]]);
        high = glm::max(high, cut.coordinates[cut.indices[i]]);
    }
    std::set<std::pair<int, int>> taken;
    for (const auto& [chart, box] : boxes) {
        for (int y = static_cast<int>(std::floor(box[0].y - 0.5f)); y <= std::floor(box[1].y + 0.5f); ++y) {
            for (int x = static_cast<int>(std::floor(box[0].x - 0.5f)); x <= std::floor(box[1].x + 0.5f); ++x) {
                EXPECT_TRUE(taken.insert({x, y}).second) << x << ", " << y;
                EXPECT_TRUE(x >= 0 && y >= 0 && x < cut.size.width && y < cut.size.height);
            }
        }
    }
}

void expect_same_triangles(const world::Primitive& of, const world::BakedPrimitive& cut) {
    ASSERT_EQ(cut.indices.size(), of.indices.size());
    for (std::size_t i = 0; i < of.indices.size(); ++i) EXPECT_EQ(cut.vertices[cut.indices[i]], of.indices[i]);
}

TEST(Unwrap, ChartsOfABallLieApartAndKeepTheirSize) {
    const world::Primitive shape = ball(12);
    const world::BakedPrimitive cut = unwrap(shape, 10.0);
    expect_same_triangles(shape, cut);
    expect_apart(cut);
    for (std::size_t i = 0; i < cut.indices.size(); i += 3) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = cut.indices[i + k], b = cut.indices[i + (k + 1) % 3];
            const float length =
                10.0f * glm::distance(shape.positions[cut.vertices[a]], shape.positions[cut.vertices[b]]);
            EXPECT_LE(glm::distance(cut.coordinates[a], cut.coordinates[b]), length + 1e-3f);
            EXPECT_GE(glm::distance(cut.coordinates[a], cut.coordinates[b]), 0.55f * length - 1e-3f);
        }
    }
}

TEST(Unwrap, LooseTrianglesOfAnySizeLieApart) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const world::Primitive shape = random_triangles(seed, 60);
        const world::BakedPrimitive cut = unwrap(shape, 3.0);
        expect_same_triangles(shape, cut);
        expect_apart(cut);
    }
}

TEST(Unwrap, TrianglesWithoutAnAreaHaveAPlaceToo) {
    world::Primitive shape = random_triangles(3, 4);
    shape.positions[1] = shape.positions[0];
    shape.positions[5] = shape.positions[4] = shape.positions[3];
    const world::BakedPrimitive cut = unwrap(shape, 3.0);
    expect_same_triangles(shape, cut);
    expect_apart(cut);
}

TEST(Unwrap, WhatIsTooLargeHasFewerTexels) {
    const world::Primitive shape = ball(4);
    const world::BakedPrimitive cut = unwrap(shape, 5000.0);
    EXPECT_GT(cut.size.width, 500);
    EXPECT_LE(std::max(cut.size.width, cut.size.height), world::BakedPrimitive::max_side);
    expect_same_triangles(shape, cut);
    expect_apart(cut);
}

}  // namespace
}  // namespace camrig::bake
