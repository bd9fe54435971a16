#include <cmath>
#include <map>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/world/backdrop/backdrop.h"
#include "core/world/backdrop/depth_pieces.h"
#include "core/world/backdrop/proxy_roles.h"
#include "core/world/gltf_loader.h"
#include "core/world/read/check_walkable.h"
#include "tests/unit/world/glb_builder.h"

// What proxies are made of that no other test has: depth images, and glTF files whose nodes have roles.
namespace camrig::world::proxies_test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

/// In millimetres, what a camera with this focal length sees that looks level from 2 m up: ground, before it a wavy
/// wall 9 m away whose foot is seen, and above it nothing.
DepthImage yard(ImageSize size, double focal_px) {
    DepthImage image{.size = size, .values = {}};
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
            const double down = (y - 0.5 * (size.height - 1)) / focal_px;
            const double ground = down > 0.0 ? 2.0 / down : 1e9;
            const bool is_wall = x > size.width / 2 && down > -0.1 && ground > 9.0;
            const double z = is_wall ? 9.0 + 0.3 * std::sin(0.2 * x) : ground;
            image.values.push_back(z < 60.0 ? static_cast<std::uint16_t>(std::lround(z * 1000.0)) : 0);
        }
    }
    return image;
}

TEST(DepthPieces, CoverWhatIsKnownOnceAndAreNear) {
    const DepthImage image = yard({203, 157}, 150.0);
    const auto pieces = depth_pieces(image, 16).value();
    std::vector<int> covered(image.values.size());
    for (const DepthPiece& piece : pieces) {
        EXPECT_LE(piece.rect.width(), 16);
        EXPECT_LE(piece.rect.height(), 16);
        for (int y = piece.rect.y0; y < piece.rect.y1; ++y) {
            for (int x = piece.rect.x0; x < piece.rect.x1; ++x) {
                const auto at = static_cast<std::size_t>(y * 203 + x);
                ++covered[at];
                EXPECT_NEAR(1.0 / piece.inverse_at(x, y), image.values[at], std::max(0.5, 0.002 * image.values[at]));
            }
        }
    }
    for (std::size_t i = 0; i < covered.size(); ++i) EXPECT_EQ(covered[i], image.values[i] != 0) << i;
    // Planes are planes: few pieces but where the wall is bent and where it ends.
    EXPECT_LT(pieces.size(), 2500u);
}

TEST(DepthPieces, WhatIsRoughIsTakenMoreCoarselyAndThenRefused) {
    DepthImage image{.size = {512, 512}, .values = {}};
    const auto with_noise = [&](double share) {
        image.values.clear();
        for (std::uint64_t i = 0; i < 512 * 512; ++i)
            image.values.push_back(static_cast<std::uint16_t>(8000.0 * (1.0 + share * (random_unit(7, 1, i) - 0.5))));
    };
    with_noise(0.02);
    const auto coarse = depth_pieces(image, 16);
    ASSERT_TRUE(coarse) << coarse.error().message;
    EXPECT_LE(coarse->size(), 65536u);
    for (const DepthPiece& piece : *coarse)
        for (int y = piece.rect.y0; y < piece.rect.y1; ++y)
            for (int x = piece.rect.x0; x < piece.rect.x1; ++x)
                EXPECT_NEAR(1.0 / piece.inverse_at(x, y), image.values[static_cast<std::size_t>(y * 512 + x)],
                            8000 * 0.033);
    with_noise(1.0);
    EXPECT_THAT(depth_pieces(image, 16).error().message, StartsWith("is too rough: within 3.2 %"));
    image.values.assign(image.values.size(), 0);
    EXPECT_THAT(depth_pieces(image, 16).error().message, StartsWith("has no depth anywhere"));
}

/// A file of nodes with one square each, 2 m wide about the origin of its node, level in the world.
ModelRef squares(const std::vector<nlohmann::json>& nodes) {
    GlbBuilder glb;
    glb.mesh({-1, 0, 1, 1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, -1, 0, -1});
    glb.json["nodes"] = nodes;
    glb.json["scenes"] = {{{"nodes", nlohmann::json::array({0})}}};
    auto model = load_model(glb.build(), {}, "place.glb");
    EXPECT_TRUE(model) << model.error().message;
    return *model;
}
nlohmann::json node(const char* name, const char* role, std::vector<int> children = {}) {
    nlohmann::json made{{"name", name}, {"mesh", 0}};
    if (*role != '\0') made["extras"] = {{"camrig_proxy", role}};
    if (!children.empty()) made["children"] = children;
    return made;
}

TEST(ProxyRoles, WithoutAnyAllOfAFileIsShapes) {
    const ModelRef model = squares({node("a", "", {1}), node("b", "")});
    const auto made = proxies_of_model(model).value();
    EXPECT_EQ(made.shapes, model);
    EXPECT_TRUE(made.walkable.empty());
}

TEST(ProxyRoles, SayWhatIsShapeAndWhatIsWalkable) {
    // place: nothing; ground and what is below it but for where people walk, 5 m along x and 3 m along y.
    nlohmann::json walk = node("walk", "walkable");
    walk["translation"] = {5, 0, -3};
    const ModelRef model = squares(
        {node("place", "", {1, 4}), node("ground", "ground", {2, 3}), node("kerb", ""), walk, node("lamp", "wall")});
    const auto made = proxies_of_model(model).value();
    std::vector<std::string> shapes;
    for (const Node& one : made.shapes->nodes)
        if (one.mesh >= 0) shapes.push_back(one.name);
    EXPECT_THAT(shapes, testing::UnorderedElementsAre("ground", "kerb", "lamp"));
    ASSERT_EQ(made.walkable.size(), 2u);
    Scene scene;
    auto backdrop = std::make_shared<Backdrop>();
    backdrop->walkable = made.walkable;
    scene.cameras.emplace_back().backdrop_here = backdrop;
    EXPECT_FALSE(why_unwalkable(scene, {4.1, 2.1, 0}));
    EXPECT_FALSE(why_unwalkable(scene, {5.9, 3.9, 0}));
    EXPECT_TRUE(why_unwalkable(scene, {6.1, 3.0, 0}));
    EXPECT_TRUE(why_unwalkable(scene, {5.0, -3.0, 0}));
}

TEST(ProxyRoles, OfACatcherAndAHoldoutEachIsOneThingOnly) {
    const ModelRef model = squares({node("place", "", {1, 2, 4}), node("wall", "wall"), node("floor", "catcher", {3}),
                                    node("tile", ""), node("glass", "holdout")});
    const auto made = proxies_of_model(model).value();
    const auto lit = [](const ModelRef& of) {
        std::map<std::string, bool> found;
        for (const Node& one : of->nodes) {
            if (one.mesh < 0) continue;
            const int material = of->meshes[static_cast<std::size_t>(one.mesh)].primitives.at(0).material;
            found[one.name] = material < 0 || !of->materials[static_cast<std::size_t>(material)].unlit;
        }
        return found;
    };
    using Found = std::map<std::string, bool>;
    EXPECT_EQ(lit(made.shapes), (Found{{"wall", true}, {"glass", false}})) << "what has no light has none to lose";
    EXPECT_EQ(lit(made.catchers), (Found{{"floor", true}, {"tile", true}}));
    EXPECT_TRUE(made.walkable.empty());
}

TEST(ProxyRoles, AnUnknownOneIsToldWithItsNode) {
    EXPECT_EQ(
        proxies_of_model(squares({node("Cube.001", "wal")})).error().message,
        "node 'Cube.001': extras.camrig_proxy: 'wal' is none of ground, obstacle, wall, catcher, holdout and walkable");
    const auto only_walkable = proxies_of_model(squares({node("walk", "walkable")})).value();
    EXPECT_EQ(only_walkable.shapes, nullptr);
}

}  // namespace
}  // namespace camrig::world::proxies_test
