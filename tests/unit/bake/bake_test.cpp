#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/unit/bake/scenes.h"

/// Baked light where the answer is known.
namespace camrig::bake {
namespace {

using world::LightSource;

constexpr glm::dvec3 up{0.0, 0.0, 1.0};
const TestBox ground{"ground", {0, 0, -0.2}, {8, 8, 0.2}, 0.0};

/// The scene in which the materials of a model are changed.
std::shared_ptr<world::Scene> changed(const std::vector<TestBox>& boxes, const std::string& model, const auto& change) {
    auto scene = std::make_shared<world::Scene>(*scene_of(boxes));
    auto other = std::make_shared<world::Model>(*scene->models.at(model).model);
    for (world::Material& material : other->materials) change(material);
    scene->models.at(model).model = other;
    return scene;
}
/// The scene in which a model is a lamp of that radiance.
std::shared_ptr<world::Scene> with_lamp(const std::vector<TestBox>& boxes, const std::string& model, double radiance) {
    return changed(boxes, model, [&](world::Material& of) { of.emissive = glm::vec3(static_cast<float>(radiance)); });
}

/// Light at a place on the ground, d before the middle of a wall of light of radiance 1 that is h high and 2 w wide
/// (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-4).
double light_of_wall(double d, double h, double w) {
    const double far = std::hypot(d, h);
    return (std::atan(w / d) - d / far * std::atan(w / far)) / std::numbers::pi;
}

/// What a box of that color (of a shape's roughness) sends on, in all directions together, of light that comes from all
/// around: glTF 2.0, appendix B, added up over views and lights.
double sent_on(double color) {
    constexpr int cosines = 48, turns = 96;
    constexpr double a2 = 0.8 * 0.8 * 0.8 * 0.8;
    const auto visibility = [](double cosine) { return 1.0 / (cosine + std::sqrt(a2 + (1.0 - a2) * cosine * cosine)); };
    double sum = 0.0;
    for (int i = 0; i < cosines; ++i) {
        for (int j = 0; j < cosines; ++j) {
            for (int k = 0; k < turns; ++k) {
                const double nv = (i + 0.5) / cosines, nl = (j + 0.5) / cosines;
                const double turn = (k + 0.5) / turns * std::numbers::pi;
                const double vl = std::sqrt((1.0 - nv * nv) * (1.0 - nl * nl)) * std::cos(turn) + nv * nl;
                const double vh = std::sqrt(0.5 * (1.0 + vl)), nh = (nv + nl) / (2.0 * vh);
                const double fresnel = 0.04 + 0.96 * std::pow(1.0 - vh, 5), d = nh * nh * (a2 - 1.0) + 1.0;
                const double mirrored = fresnel * a2 / (d * d) * visibility(nl) * visibility(nv);
                sum += 4.0 * nl * nv * ((1.0 - fresnel) * color + mirrored);
            }
        }
    }
    return sum / (cosines * cosines * turns);
}

TEST(Bake, OpenGroundHasAllOfTheSkyAndNothingFromBelow) {
    const auto scene = scene_of({ground});
    const world::BakedLight light = baked(scene);
    EXPECT_NEAR(light_at(scene, light, layer_of(light, LightSource::sky), "ground", {1.3, -2.1, 0}, up).g, 1.0, 0.01);
    EXPECT_NEAR(light_at(scene, light, layer_of(light, LightSource::ground), "ground", {1.3, -2.1, 0}, up).g, 0.0,
                0.001);
}

TEST(Bake, AtTheFootOfAHighBlackWallHalfOfTheSkyIsLeft) {
    const auto scene =
        scene_of({{"ground", {0, 0, -0.2}, {2, 80, 0.2}, 0.0}, {"wall", {1.5, 0, -0.2}, {1, 80, 80}, 0.0}});
    const world::BakedLight light = baked(scene, {.texels_per_m = 2.0, .rays = 512});
    const double d = 1.0, h = 79.8;
    // A wall as long as that, seen from d before it, hides (1 - d / sqrt(d^2 + h^2)) / 2.
    const double hidden = 0.5 * (1.0 - d / std::hypot(d, h));
    // Of what comes to the wall, half of the sky, a black surface mirrors a little.
    EXPECT_NEAR(light_at(scene, light, 0, "ground", {0, 0, 0}, up).g, 1.0 - hidden + sent_on(0.0) * 0.5 * hidden, 0.01);
}

TEST(Bake, APaneColorsLightAndMirrorsAPartOfIt) {
    const glm::vec3 tint(0.5f, 1.3f, 1.2f);
    // A pane as wide as the sky, close over black ground; light goes through its upper and through its lower face.
    const auto scene = changed({{"ground", {0, 0, -0.2}, {4, 4, 0.2}, 0.0}, {"pane", {0, 0, 0.3}, {90, 90, 0.01}, 0.0}},
                               "pane", [&](world::Material& material) {
                                   material.transmission = 1.0f;
                                   material.alpha_mode = world::AlphaMode::blend;
                                   material.base_color.a = 0.1f;
                                   material.tint = tint;
                               });
    const world::BakedLight light = baked(scene, {.texels_per_m = 1.0, .rays = 4096, .probe_spacing_m = 40.0});
    // By the angles of Fresnel's law (Born and Wolf, Principles of Optics, 1.5.2), over a hemisphere by cosine.
    double passed = 0.0;
    constexpr int steps = 20000;
    for (int i = 0; i < steps; ++i) {
        const double sine2 = (i + 0.5) / steps, outside = std::asin(std::sqrt(sine2));
        const double inside = std::asin(std::sqrt(sine2) / 1.5);
        const double across = std::sin(outside - inside) / std::sin(outside + inside);
        const double along = std::tan(outside - inside) / std::tan(outside + inside);
        const double mirrored = 0.5 * (across * across + along * along);
        passed += std::pow(0.9 * (1.0 - mirrored) / (1.0 + mirrored), 2) / steps;
    }
    const glm::vec3 found = light_at(scene, light, layer_of(light, LightSource::sky), "ground", {0.3, 0.2, 0}, up);
    for (glm::length_t c = 0; c < 3; ++c)
        EXPECT_NEAR(found[c], passed * tint[c] * tint[c], 0.006 * tint[c] * tint[c]) << c;
}

TEST(Bake, InAClosedRoomNoSkyIsSeen) {
    const auto scene = scene_of(room({3, 4, 2.5}, 0.6));
    const world::BakedLight light = baked(scene);
    for (const double x : {-1.4, 0.2, 1.45})
        EXPECT_LT(light_at(scene, light, 0, "floor", {x, 1.9, 0}, up).g, 1e-3) << x;
}

TEST(Bake, ALampOverABlackFloorFollowsDistanceAndCosine) {
    const auto scene = scene_of({ground}, R"(, "lights": [{"name": "lamp", "type": "point", "position": [0, 0, 2]}])");
    const world::BakedLight light = baked(scene, {.texels_per_m = 8.0, .rays = 64});
    const std::size_t layer = layer_of(light, LightSource::lamp);
    for (const double r : {0.0, 1.0, 2.5})
        EXPECT_NEAR(light_at(scene, light, layer, "ground", {r, 0, 0}, up).g, 2.0 / std::pow(4.0 + r * r, 1.5), 0.004)
            << r;
}

TEST(Bake, LampsOfAGroupAreOneLayerWithTheLightOfAll) {
    const auto light_of = [](const std::string& lamps) {
        const auto scene = scene_of({ground}, R"(, "lights": [)" + lamps + "]");
        const world::BakedLight light = baked(scene, {.texels_per_m = 8.0, .rays = 64});
        double sum = 0.0;
        for (std::size_t i = 0; i < light.layers.size(); ++i)
            if (light.layers[i].source == LightSource::lamp)
                sum += light_at(scene, light, i, "ground", {0.3, 0, 0}, up).g;
        return std::pair(sum, std::ranges::count(light.layers, LightSource::lamp, &world::LightLayer::source));
    };
    const auto two = [&](const std::string& more) {
        return light_of(R"({"name": "a", "type": "point", "position": [0, 0, 2])" + more +
                        R"(}, {"name": "b", "type": "point", "position": [2, 0, 1])" + more + "}");
    };
    const auto [apart, layers_apart] = two("");
    const auto [together, layers_together] = two(R"(, "group": "lamps")");
    EXPECT_EQ(layers_apart, 2);
    EXPECT_EQ(layers_together, 1);
    EXPECT_NEAR(together, apart, 0.004);
}

/// A small square of radiance L and area A, the lower side of a cube, over a black floor, d below it: L A / (pi d^2).
TEST(Bake, ALampThatIsASurfaceIsMetByEveryPlace) {
    const double l = 100.0, side = 0.1, d = 2.0;
    const auto scene = with_lamp(
        {ground, {"lamp", {0, 0, d}, {side, side, side}, 0.0}, {"block", {1, 0, 0}, {0.5, 0.5, 0.5}, 0.0}}, "lamp", l);
    const world::BakedLight light = baked(scene, {.texels_per_m = 8.0, .rays = 64, .probe_spacing_m = 4.0});
    const std::size_t layer = layer_of(light, LightSource::glow);
    const double below = l * side * side / (std::numbers::pi * (d - 0.5 * side) * (d - 0.5 * side));
    EXPECT_NEAR(light_at(scene, light, layer, "ground", {0, 0, 0}, up).g, below, 0.02 * below);
    EXPECT_LT(light_at(scene, light, layer, "ground", {1.31, 0, 0}, up).g, 0.2 * below)
        << "the block hides it; without it there would be half as much as below the lamp";
}

/// The lamp's two triangles have their middles below the floor; its upper part alone is seen.
TEST(Bake, ALampThatMostlyLiesBelowTheFloorLightsIt) {
    const double l = 10.0, h = 1.0, w = 1.0, d = 3.5;
    const auto scene = with_lamp({ground, {"wall", {d + 0.5, 0, h - 3}, {1, 2 * w, 3}, 0.0}}, "wall", l);
    const world::BakedLight light = baked(scene, {.texels_per_m = 8.0, .rays = 1024, .probe_spacing_m = 4.0});
    const double seen = l * light_of_wall(d, h, w);
    EXPECT_NEAR(light_at(scene, light, layer_of(light, LightSource::glow), "ground", {0, 0, 0}, up).g, seen,
                0.03 * seen);
}

TEST(Bake, BesideALargeLampItIsAsBrightAsItsSizeSays) {
    for (const double d : {0.75, 1.0, 2.0}) {
        const double l = 10.0, h = 2.0, w = 2.0;
        const auto scene = with_lamp({ground, {"wall", {d + 0.5, 0, 0}, {1, 2 * w, h}, 0.0}}, "wall", l);
        const world::BakedLight light = baked(scene, {.texels_per_m = 8.0, .rays = 256, .probe_spacing_m = 4.0});
        const double seen = l * light_of_wall(d, h, w);
        EXPECT_NEAR(light_at(scene, light, layer_of(light, LightSource::glow), "ground", {0, 0, 0}, up).g, seen,
                    0.05 * seen)
            << d;
    }
}

/// A thin sign that is dark where the middles of its two triangles are.
TEST(Bake, ALampWithDarkPlacesInItsTextureIsMet) {
    const double l = 100.0, side = 0.1, d = 2.0;
    auto scene = std::make_shared<world::Scene>(*scene_of({ground, {"lamp", {0, 0, d}, {side, side, 0.001}, 0.0}}));
    auto glowing = std::make_shared<world::Model>(*scene->models.at("lamp").model);
    constexpr int size = 12, dark = 6;
    world::Image sign{{size, size}, std::vector<std::uint8_t>(std::size_t{4} * size * size, 255)};
    double lit = 0.0;
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            const bool is_dark = std::abs(2 * x + 1 - size) < dark && std::abs(2 * y + 1 - size) < dark;
            lit += is_dark ? 0.0 : 1.0 / (size * size);
            for (std::size_t i = 0; i < 3; ++i)
                sign.rgba[4 * static_cast<std::size_t>(y * size + x) + i] = is_dark ? 0 : 255;
        }
    }
    glowing->textures.push_back({.image = static_cast<int>(glowing->images.size()), .sampler = {}});
    glowing->images.push_back(std::move(sign));
    for (world::Material& material : glowing->materials) {
        material.emissive = glm::vec3(static_cast<float>(l));
        material.emissive_texture.texture = static_cast<int>(glowing->textures.size()) - 1;
    }
    scene->models.at("lamp").model = glowing;
    const world::BakedLight light = baked(scene, {.texels_per_m = 8.0, .rays = 1024, .probe_spacing_m = 4.0});
    const double below = lit * l * side * side / (std::numbers::pi * d * d);
    EXPECT_NEAR(light_at(scene, light, layer_of(light, LightSource::glow), "ground", {0, 0, 0}, up).g, below,
                0.04 * below);
}

TEST(Bake, ALampThatIsSeenFromBothSidesShinesToBoth) {
    const double l = 100.0, side = 0.2, d = 2.0;
    auto scene = std::make_shared<world::Scene>(*scene_of({ground, {"lamp", {0, 0, d}, {side, side, 0.001}, 0.0}}));
    auto panel = std::make_shared<world::Model>(*scene->models.at("lamp").model);
    // Of the box its top alone.
    world::Primitive& primitive = panel->meshes[0].primitives[0];
    std::vector<std::uint32_t> top;
    for (std::size_t i = 0; i < primitive.indices.size(); i += 3)
        if (primitive.normals[primitive.indices[i]].y > 0.5f)
            top.insert(top.end(), primitive.indices.begin() + static_cast<std::ptrdiff_t>(i),
                       primitive.indices.begin() + static_cast<std::ptrdiff_t>(i) + 3);
    ASSERT_EQ(top.size(), 6u);
    primitive.indices = top;
    panel->materials[0].emissive = glm::vec3(static_cast<float>(l));
    for (const bool both : {true, false}) {
        panel = std::make_shared<world::Model>(*panel);
        panel->materials[0].double_sided = both;
        scene->models.at("lamp").model = panel;
        const world::BakedLight light = baked(scene, {.texels_per_m = 8.0, .rays = 64, .probe_spacing_m = 4.0});
        const double below = both ? l * side * side / (std::numbers::pi * d * d) : 0.0;
        EXPECT_NEAR(light_at(scene, light, layer_of(light, LightSource::glow), "ground", {0, 0, 0}, up).g, below, 0.015)
            << both;
    }
}

TEST(Bake, ASurfaceThatIsTooLargeForItsTexelsHasFewer) {
    const auto scene = scene_of({{"ground", {0, 0, -0.2}, {300, 300, 0.2}, 0.0}, {"box", {3, 0, 0}, {1, 1, 1}, 0.5}});
    const world::BakedLight light =
        baked(scene, {.texels_per_m = 10.0, .max_side = 512, .rays = 16, .probe_spacing_m = 40.0});
    ASSERT_EQ(light.objects.size(), 2u);
    for (const world::BakedObject& object : light.objects) EXPECT_EQ(object.surfaces.size(), 1u) << object.name;
    EXPECT_NEAR(light_at(scene, light, layer_of(light, LightSource::sky), "ground", {100, 100, 0}, up).g, 1.0, 0.02);
}

TEST(Bake, MoreLampsThanItCanKeepAreAnError) {
    std::string lamps;
    for (int i = 0; i < 70; ++i)
        lamps +=
            fmt::format(R"({}{{"name": "l{}", "type": "point", "position": [{}, 0, 1]}})", i == 0 ? "" : ", ", i, i);
    const auto light = bake(scene_of({ground}, R"(, "lights": [)" + lamps + "]"), {.rays = 16});
    ASSERT_FALSE(light.has_value());
    EXPECT_NE(light.error().message.find("70 that are switched apart"), std::string::npos) << light.error().message;
}

TEST(Bake, ALampsShadowIsDark) {
    const auto scene = scene_of({ground, {"block", {1, 0, 0}, {0.5, 0.5, 0.5}, 0.0}},
                                R"(, "lights": [{"name": "lamp", "type": "point", "position": [0, 0, 1]}])");
    const world::BakedLight light = baked(scene, {.texels_per_m = 8.0, .rays = 64});
    const std::size_t layer = layer_of(light, LightSource::lamp);
    EXPECT_LT(light_at(scene, light, layer, "ground", {1.5, 0, 0}, up).g, 1e-3);
    EXPECT_GT(light_at(scene, light, layer, "ground", {-1.5, 0, 0}, up).g, 0.1);
}

TEST(Bake, AFaceIsNotFilteredFromAnothersTexels) {
    // A lamp over a black block: its top is lit, and no point of its sides sees the lamp.
    const auto scene = scene_of({{"block", {0, 0, 0}, {1.37, 0.91, 0.6}, 0.0}},
                                R"(, "lights": [{"name": "lamp", "type": "point", "position": [0, 0, 1.5]}])");
    for (const double texels_per_m : {2.0, 3.7, 8.0}) {
        const world::BakedLight light = baked(scene, {.texels_per_m = texels_per_m, .rays = 16});
        const std::size_t layer = layer_of(light, LightSource::lamp);
        EXPECT_GT(light_at(scene, light, layer, "block", {0.1, 0.1, 0.6}, up).g, 0.9);
        for (double share = -0.499; share < 0.5; share += 0.0499) {
            for (const double z : {0.0, 0.3, 0.6}) {
                for (const double side : {-1.0, 1.0}) {
                    EXPECT_LT(light_at(scene, light, layer, "block", {side * 0.685, 0.91 * share, z}, {side, 0, 0}).g,
                              1e-3);
                    EXPECT_LT(light_at(scene, light, layer, "block", {1.37 * share, side * 0.455, z}, {0, side, 0}).g,
                              1e-3);
                }
            }
        }
    }
}

TEST(Bake, OfTheSunOnlyWhatIsReflectedIsInTheMap) {
    // A black floor takes nothing from itself; under a white roof's edge it has what the wall sends.
    const auto scene =
        scene_of({ground}, R"(, "lights": [{"name": "sun", "type": "directional", "direction": [0, 0, -1]}])");
    const world::BakedLight light = baked(scene);
    EXPECT_LT(light_at(scene, light, layer_of(light, LightSource::lamp), "ground", {0, 0, 0}, up).g, 1e-3);
    const auto lit = scene_of({{"ground", {0, 0, -0.2}, {8, 8, 0.2}, 0.5}, {"wall", {2, 0, 0}, {1, 8, 4}, 0.0}},
                              R"(, "lights": [{"name": "sun", "type": "directional", "direction": [0, 0, -1]}])");
    const world::BakedLight there = baked(lit, {.texels_per_m = 4.0, .rays = 512});
    // The wall's middle sees the ground in the lower half of its view, as far as it goes.
    const double d = 5.5, h = 1.0, r = sent_on(0.5);
    const double seen = light_at(lit, there, layer_of(there, LightSource::lamp), "wall", {1.5, 0, h}, {-1, 0, 0}).g;
    EXPECT_NEAR(seen, r * 0.5 * (1.0 - h / std::hypot(d, h)), 0.02);
}

/// A room that glows: of albedo a and own light e, light is e / (1 - a) everywhere.
TEST(Bake, AWhiteFurnaceIsAsBrightAsTheSeriesSays) {
    const auto boxes = room({3, 3, 3}, 0.5);
    auto scene = std::make_shared<world::Scene>(*scene_of(boxes));
    for (auto& [name, model] : scene->models) {
        auto glowing = std::make_shared<world::Model>(*model.model);
        for (world::Material& material : glowing->materials) material.emissive = glm::vec3(0.25f);
        model.model = glowing;
    }
    const world::BakedLight light = baked(scene, {.texels_per_m = 3.0, .rays = 256, .bounces = 8});
    const double expected = 0.25 / (1.0 - sent_on(0.5));
    const std::size_t layer = layer_of(light, LightSource::glow);
    for (const glm::dvec3 place : {glm::dvec3(0.2, 0.1, 0), glm::dvec3(-1.4, 1.4, 0), glm::dvec3(1.1, -1.45, 0)})
        EXPECT_NEAR(light_at(scene, light, layer, "floor", place, up).g, expected, 0.02 * expected);
    // A place in the middle of it is lit so from all sides.
    for (std::size_t i = 0; i < light.grid.size(); ++i) {
        if (light.grid.is_open[i] == 0) continue;
        const world::LightProbe& probe = light.layers[layer].probes[i];
        EXPECT_NEAR(probe.mean.g, expected, 0.03 * expected) << i;
        for (glm::length_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(probe.along[axis].g, 0.0, 0.05 * expected) << i;
        for (const glm::vec3& product : probe.products) EXPECT_NEAR(product.g, 0.0, 0.05 * expected) << i;
    }
}

/// A black box whose faces are thin, without anything around it.
world::SceneRef thin_box(double side) {
    auto scene = std::make_shared<world::Scene>(*scene_of({{"box", {0, 0, 1}, glm::dvec3(side), 0.0}}));
    auto model = std::make_shared<world::Model>(*scene->models.at("box").model);
    for (world::Material& material : model->materials) material.double_sided = true;
    scene->models.at("box").model = model;
    return scene;
}

TEST(Bake, ASmoothFloorShowsAWallTheMirrorImageOfALamp) {
    const auto light_with_floor = [](double color) {
        auto scene = with_lamp({{"ground", {0, 0, -0.2}, {10, 6, 0.2}, color},
                                {"wall", {3.5, 0, -0.2}, {1, 6, 4}, 0.0},
                                {"lamp", {0, 0, 2}, {4, 4, 0.2}, 0.0}},
                               "lamp", 1.0);
        auto floor = std::make_shared<world::Model>(*scene->models.at("ground").model);
        for (world::Material& material : floor->materials) {
            material.roughness = 0.05f;
            material.metallic = 1.0f;
        }
        scene->models.at("ground").model = floor;
        return [scene, light = baked(scene, {.texels_per_m = 10.0, .rays = 512})](double height) {
            const glm::dvec3 normal{-1.0, 0.0, 0.0};
            return light_at(scene, light, layer_of(light, LightSource::glow), "wall", {3.0, 0.0, height}, normal).g;
        };
    };
    const auto of_metal = light_with_floor(0.5), of_black = light_with_floor(0.0);
    for (const double height : {0.3, 2.6}) {
        // The lamp's lower face and the one towards the wall, in the floor.
        constexpr int steps = 200;
        double expected = 0.0;
        const auto add = [&](const glm::dvec3& to_wall, const glm::dvec3& faces, double area) {
            const double distance2 = glm::dot(to_wall, to_wall);
            const double cosines = std::max(0.0, glm::dot(faces, to_wall)) * to_wall.x / distance2;
            expected += 0.5 * cosines * area / (steps * steps) / (std::numbers::pi * distance2);
        };
        for (int i = 0; i < steps; ++i) {
            for (int j = 0; j < steps; ++j) {
                const double u = (i + 0.5) / steps, v = (j + 0.5) / steps;
                add({5.0 - 4.0 * u, 2.0 - 4.0 * v, height + 2.0}, {0.0, 0.0, 1.0}, 16.0);
                add({1.0, 2.0 - 4.0 * u, height + 2.0 + 0.2 * v}, {1.0, 0.0, 0.0}, 0.8);
            }
        }
        EXPECT_NEAR((of_metal(height) - of_black(height)) / expected, 1.0, 0.06) << height;
    }
}

TEST(Bake, OfAThinSurfaceTheSideCountsThatIsSeenFromFar) {
    const auto top_of = [](double side) {
        const auto scene = thin_box(side);
        const world::BakedLight light = baked(scene);
        return light_at(scene, light, layer_of(light, LightSource::sky), "box", {0.1, 0.1, 1.0 + side}, up).g;
    };
    EXPECT_GT(top_of(1.0), 0.97f) << "its inside is seen by nobody";
    EXPECT_NEAR(top_of(20.0), 0.5f, 0.02f) << "in a hall one may stand on either side";
}

TEST(Bake, ProbesInTheOpenHaveSkyAboveAndGroundBelow) {
    // High over a small block.
    const auto scene = scene_of({{"block", {0, 0, 0}, {0.2, 0.2, 0.2}, 0.0}});
    const world::BakedLight light = baked(scene, {.texels_per_m = 4.0, .rays = 64, .probe_spacing_m = 4.0});
    ASSERT_EQ(light.grid.size(), 1u);
    const world::LightProbe& sky = light.layers[0].probes[0];
    EXPECT_NEAR(sky.mean.g, 0.5, 0.01);
    EXPECT_NEAR(sky.along[2].g, 0.5, 0.02);
    // A half space has no second order.
    for (const glm::vec3& product : sky.products) EXPECT_NEAR(product.g, 0.0, 0.03);
}

TEST(Bake, ProbesKnowWhereALampIsToTheSecondOrder) {
    const auto scene = scene_of({{"block", {0, 0, 0}, {0.2, 0.2, 0.2}, 0.0}},
                                R"(, "lights": [{"name": "lamp", "type": "point", "position": [3, 3, 40]}])");
    const world::BakedLight light = baked(scene, {.texels_per_m = 4.0, .rays = 64, .probe_spacing_m = 4.0});
    const world::LightProbe& probe = light.layers[layer_of(light, LightSource::lamp)].probes.front();
    const glm::vec3 way = glm::vec3(3, 3, 40) - glm::vec3(light.grid.first);
    const float squarely = 1.0f / glm::dot(way, way);
    const auto products = world::products_of(glm::normalize(way));
    EXPECT_NEAR(probe.mean.g / squarely, 0.25, 0.01);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_NEAR(probe.products[i].g / squarely, 15.0 / 16.0 * products[i], 0.02) << i;
    EXPECT_NEAR(probe.products[4].g / squarely, 5.0 / 64.0 * products[4], 0.01);
}

TEST(Bake, IsTheSameWithAnyNumberOfThreads) {
    const auto scene = scene_of({ground, {"block", {1, 0, 0}, {1, 2, 1.5}, 0.7}},
                                R"(, "lights": [{"name": "lamp", "type": "point", "position": [0, 0, 1]}])");
    const auto one = encode_baked_light(baked(scene, {.texels_per_m = 4.0, .rays = 64, .threads = 1}));
    const auto three = encode_baked_light(baked(scene, {.texels_per_m = 4.0, .rays = 64, .threads = 3}));
    EXPECT_EQ(one, three);
}

TEST(Bake, EndsWhenItIsTold) {
    const auto scene = scene_of({ground});
    const auto light = bake(scene, {.texels_per_m = 4.0, .rays = 64, .progress = [](double) { return false; }});
    ASSERT_FALSE(light.has_value());
    EXPECT_EQ(light.error().kind, ErrorKind::unavailable);
}

TEST(Bake, IsNoneWhenItIsToldToEndInItsLastParts) {
    const auto scene = scene_of({ground, {"block", {1, 0, 0}, {1, 2, 1.5}, 0.7}});
    for (const double last : {0.93, 0.96}) {  // while the map is smoothed, and while places are looked at
        bool was_told = false;
        const auto light = bake(scene, {.texels_per_m = 4.0, .rays = 64, .threads = 1, .progress = [&](double done) {
                                            was_told |= done >= last;
                                            return !was_told;
                                        }});
        EXPECT_TRUE(was_told) << last;
        EXPECT_FALSE(light.has_value()) << last;
    }
}

TEST(Bake, MapsThatWouldBeTooLargeHaveFewerTexels) {
    const auto scene = scene_of({ground});
    const world::BakedLight light = baked(scene, {.texels_per_m = 200.0, .max_side = 256, .rays = 16});
    EXPECT_LE(light.size.width, 256);
    EXPECT_LE(light.size.height, 256);
    EXPECT_GT(light.size.pixels(), 128 * 128);
}

}  // namespace
}  // namespace camrig::bake
