// Shading and shadows against known answers, and what quality must not change.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include "core/render/shadow_plan.h"
#include "tests/render/support/test_rig.h"

namespace camrig::render {
namespace {

constexpr world::Quality all_qualities[] = {world::Quality::fast, world::Quality::simple, world::Quality::beautiful};
constexpr double pi = std::numbers::pi;

world::Environment darkness() {
    return {.background = glm::vec3(0.0f), .ambient_sky = glm::vec3(0.0f), .ambient_ground = glm::vec3(0.0f)};
}

world::Material surface(glm::vec3 color, float roughness, float metallic = 0.0f) {
    world::Material material = colored(color);
    material.roughness = roughness;
    material.metallic = metallic;
    return material;
}

/// A ball of radius 1 whose normals are exact at the vertices.
world::Primitive ball() {
    constexpr int around = 192, down = 96;
    world::Primitive p;
    for (int j = 0; j <= down; ++j) {
        for (int i = 0; i <= around; ++i) {
            const double a = 2 * pi * i / around, b = pi * j / down;
            p.positions.emplace_back(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b));
        }
    }
    p.normals = p.positions;
    for (std::uint32_t j = 0; j < down; ++j) {
        for (std::uint32_t i = 0; i < around; ++i) {
            const std::uint32_t a = j * (around + 1) + i, b = a + around + 1;
            for (const std::uint32_t index : {a, b, b + 1, a, b + 1, a + 1}) p.indices.push_back(index);
        }
    }
    return p;
}

const glm::dvec3 ball_at(4.0, 0.0, 0.0);
const TestCamera ball_camera{.size = {161, 161}, .focal_px = 260.0};

/// Calls `check` with pixel, the point of the ball that it shows and the normal there, except close to the outline.
void for_each_ball_pixel(const std::function<void(int, int, glm::dvec3, glm::dvec3)>& check) {
    for (int y = 0; y < 161; y += 4) {
        for (int x = 0; x < 161; x += 4) {
            const glm::dvec3 ray = glm::normalize(glm::dvec3(260.0, 80.0 - x, 80.0 - y));
            const double along = glm::dot(ray, ball_at), inside = along * along - glm::dot(ball_at, ball_at) + 1.0;
            if (inside < 0.05) continue;
            const glm::dvec3 point = ray * (along - std::sqrt(inside));
            check(x, y, point, point - ball_at);
        }
    }
}

/// What quality beautiful shows of a lit surface's light by day: PBR Neutral of the Khronos Group, written out.
glm::dvec3 shown(const glm::dvec3& light) {
    const double least = std::min({light.r, light.g, light.b});
    const glm::dvec3 color = light - (least < 0.08 ? least - 6.25 * least * least : 0.04);
    const double peak = std::max({color.r, color.g, color.b});
    if (peak < 0.76) return color;
    const double compressed = 1.0 - 0.24 * 0.24 / (peak + 0.24 - 0.76);
    return glm::mix(color * (compressed / peak), glm::dvec3(compressed),
                    1.0 - 1.0 / (0.15 * (peak - compressed) + 1.0));
}
TEST(Quality, ByDaylightWhatIsOverWhiteIsCompressedAtBeautifulAndFades) {
    for (const glm::vec3 light : {glm::vec3(0.05f), glm::vec3(0.3f, 0.1f, 0.02f), glm::vec3(0.9f), glm::vec3(3.0f),
                                  glm::vec3(8.0f, 2.0f, 0.5f)}) {
        TestWorld world;
        world.environment = {.background = {}, .ambient_sky = light, .ambient_ground = light};
        world.objects = {instance_of(model_of(ball(), surface(glm::vec3(1.0f), 1.0f, 1.0f)), ball_at)};
        TestCamera camera = ball_camera;
        for (const bool by_day : {false, true})
            for (const world::Quality quality : all_qualities) {
                if (by_day) world.environment.daylight.emplace();
                camera.quality = quality;
                const Picture picture = draw(world, camera);
                const bool is_toned = by_day && quality == world::Quality::beautiful;
                const glm::dvec3 expected = is_toned ? shown(glm::dvec3(light)) : glm::dvec3(light);
                EXPECT_NEAR(picture.red(80, 80), srgb_code(std::min(expected.r, 1.0)), 1) << int(quality);
                EXPECT_NEAR(picture.at(80, 80)[1], srgb_code(std::min(expected.g, 1.0)), 1) << int(quality);
                EXPECT_NEAR(picture.at(80, 80)[2], srgb_code(std::min(expected.b, 1.0)), 1) << int(quality);
            }
    }
}

TEST(Quality, ALambertBallUnderTheSunIsAnalytic) {
    const glm::dvec3 towards = glm::normalize(glm::dvec3(-1.0, 0.7, 0.5));
    for (const world::Quality quality : {world::Quality::fast, world::Quality::simple}) {
        TestWorld world;
        world.environment = darkness();
        world.lights = {light_of(world::LightType::directional, 0.9f, {}, -towards)};
        world.objects = {instance_of(model_of(ball(), colored(glm::vec3(0.8f))), ball_at)};
        TestCamera camera = ball_camera;
        camera.quality = quality;
        const Picture picture = draw(world, camera);
        for_each_ball_pixel([&](int x, int y, glm::dvec3, glm::dvec3 n) {
            EXPECT_NEAR(linear_of(picture.red(x, y)), 0.72 * std::max(0.0, glm::dot(n, towards)), 0.01)
                << int(quality) << " " << x << " " << y;
        });
    }
}

/// glTF 2.0, appendix B, written out: radiance towards v of a surface lit from l by a light of irradiance pi.
double gltf_reflection(glm::dvec3 n, glm::dvec3 v, glm::dvec3 l, double base, double roughness, double metallic) {
    const glm::dvec3 h = glm::normalize(v + l);
    const double nl = glm::dot(n, l), nv = glm::dot(n, v), nh = glm::dot(n, h), vh = glm::dot(v, h);
    if (nl <= 0.0 || nv <= 0.0) return 0.0;
    const double alpha = roughness * roughness;
    const double d = alpha * alpha / (pi * std::pow(nh * nh * (alpha * alpha - 1.0) + 1.0, 2.0));
    const auto masked = [&](double cosine) {
        return 2.0 * cosine / (cosine + std::sqrt(alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine));
    };
    const double specular = d * masked(nl) * masked(nv) / (4.0 * nl * nv);
    const double f0 = 0.04 * (1.0 - metallic) + base * metallic;
    const double fresnel = f0 + (1.0 - f0) * std::pow(1.0 - vh, 5.0);
    return pi * nl * ((1.0 - fresnel) * base * (1.0 - metallic) / pi + fresnel * specular);
}

TEST(Quality, AGgxHighlightIsThatOfTheFormula) {
    // f0 so low, or roughness, that what microfacets lose among each other is below a code.
    const glm::dvec3 towards = glm::normalize(glm::dvec3(-1.0, 0.5, 0.6));
    for (const double roughness : {0.25, 0.5, 0.9}) {
        TestWorld world;
        world.environment = darkness();
        world.lights = {light_of(world::LightType::directional, 0.5f, {}, -towards)};
        world.objects = {
            instance_of(model_of(ball(), surface(glm::vec3(0.6f), static_cast<float>(roughness))), ball_at)};
        TestCamera camera = ball_camera;
        camera.quality = world::Quality::beautiful;
        const Picture picture = draw(world, camera);
        double worst = 0.0, brightest = 0.0;
        for_each_ball_pixel([&](int x, int y, glm::dvec3 point, glm::dvec3 n) {
            // Along the terminator the map decides, not the formula.
            if (std::abs(glm::dot(n, towards)) < 0.05) return;
            const double expected =
                std::min(1.0, 0.5 * gltf_reflection(n, -glm::normalize(point), towards, 0.6, roughness, 0.0));
            worst = std::max(worst, std::abs(linear_of(picture.red(x, y)) - expected));
            brightest = std::max(brightest, expected);
        });
        std::printf("roughness %g: brightest %.3f, worst difference %.4f\n", roughness, brightest, worst);
        EXPECT_LT(worst, 0.012) << roughness;
    }
}

TEST(Quality, AWhiteMetalInAWhiteRoomIsWhite) {
    for (const float roughness : {0.0f, 0.3f, 0.6f, 1.0f}) {
        TestWorld world;
        world.environment = {
            .background = glm::vec3(0.5f), .ambient_sky = glm::vec3(0.5f), .ambient_ground = glm::vec3(0.5f)};
        world.objects = {instance_of(model_of(ball(), surface(glm::vec3(1.0f), roughness, 1.0f)), ball_at)};
        TestCamera camera = ball_camera;
        camera.quality = world::Quality::beautiful;
        const Picture picture = draw(world, camera);
        for_each_ball_pixel([&](int x, int y, glm::dvec3, glm::dvec3) {
            EXPECT_NEAR(picture.red(x, y), srgb_code(0.5), 1) << roughness;
        });
    }
}

TEST(Quality, GreyInAWhiteRoomReflectsWhatTheFormulaIntegratesTo) {
    for (const double roughness : {0.4, 0.8}) {
        TestWorld world;
        world.environment = {.background = {}, .ambient_sky = glm::vec3(0.9f), .ambient_ground = glm::vec3(0.9f)};
        world.objects = {
            instance_of(model_of(ball(), surface(glm::vec3(0.3f), static_cast<float>(roughness))), ball_at)};
        TestCamera camera = ball_camera;
        camera.quality = world::Quality::beautiful;
        const Picture picture = draw(world, camera);
        int checked = 0;
        for_each_ball_pixel([&](int x, int y, glm::dvec3 point, glm::dvec3 n) {
            if (y != 80 || x < 80) return;
            const double cosine = glm::dot(n, -glm::normalize(point));
            const glm::dvec3 v(std::sqrt(std::max(0.0, 1.0 - cosine * cosine)), 0.0, cosine);
            // Over the hemisphere of light, on a grid.
            constexpr int steps = 300;
            double sum = 0.0;
            for (int i = 0; i < steps; ++i) {
                const double theta = (i + 0.5) * 0.5 * pi / steps;
                for (int k = 0; k < steps; ++k) {
                    const double turn = (k + 0.5) * pi / steps;
                    const glm::dvec3 l(std::sin(theta) * std::cos(turn), std::sin(theta) * std::sin(turn),
                                       std::cos(theta));
                    sum += std::sin(theta) * gltf_reflection({0, 0, 1}, v, l, 0.3, roughness, 0.0);
                }
            }
            // Of a light of irradiance pi in each direction; both sides of the plane of view are alike.
            const double expected = 0.9 * sum * (0.5 * pi / steps) * (pi / steps) * 2.0 / pi;
            EXPECT_NEAR(linear_of(picture.red(x, y)), expected, 0.005) << roughness << " " << cosine;
            ++checked;
        });
        EXPECT_GT(checked, 12);
    }
}

TEST(Quality, LevelsAgreeInTheLightOfTheSurroundings) {
    TestWorld world;
    world.environment.ambient_sky = {0.8f, 0.7f, 0.6f};
    world.environment.ambient_ground = {0.2f, 0.25f, 0.3f};
    world.objects = {instance_of(model_of(ball(), surface(glm::vec3(0.7f), 1.0f)), ball_at)};
    TestCamera camera = ball_camera;
    std::vector<Picture> pictures;
    for (const world::Quality quality : all_qualities) {
        camera.quality = quality;
        pictures.push_back(draw(world, camera));
    }
    for_each_ball_pixel([&](int x, int y, glm::dvec3, glm::dvec3) {
        EXPECT_NEAR(pictures[0].red(x, y), pictures[1].red(x, y), 1);
        EXPECT_NEAR(pictures[2].red(x, y), pictures[1].red(x, y), 8);  // four hundredths are mirrored
    });
}

TEST(Quality, BakedOcclusionDarkensTheSurroundingsAtEveryLevelAndNeverTheLights) {
    for (const world::Quality quality : all_qualities) {
        auto model = model_of(rectangle({2, 0, 0}, {0, -4, 0}, {0, 0, 4}), surface(glm::vec3(1.0f), 1.0f));
        model->images.push_back({.size = {1, 1}, .rgba = {64, 0, 0, 255}});
        model->textures.push_back({.image = 0, .sampler = {}});
        model->materials[0].occlusion_texture = {.texture = 0};
        TestWorld world;
        world.environment.ambient_sky = world.environment.ambient_ground = glm::vec3(0.6f);
        world.objects = {instance_of(model)};
        TestCamera camera{.size = {16, 16}, .focal_px = 16, .quality = quality};
        EXPECT_NEAR(linear_of(draw(world, camera).red(8, 8)), 0.6 * 64 / 255, 0.02) << int(quality);
        world.environment = darkness();
        world.lights = {light_of(world::LightType::directional, 0.5f, {}, {1, 0, 0})};
        EXPECT_NEAR(linear_of(draw(world, camera).red(8, 8)), 0.5, 0.02) << int(quality);
    }
}

TEST(Quality, GlassColorsWhatIsBehindItInEachColor) {
    const glm::vec3 tint(0.3f, 1.1f, 0.8f);
    const auto sheet = rectangle({0, 0, 0}, {0, -4, 0}, {0, 0, 4});
    world::Material wall = surface(glm::vec3(0.6f), 1.0f), glass = surface(glm::vec3(0.0f), 0.02f);
    wall.unlit = true;
    glass.transmission = 1.0f;
    glass.alpha_mode = world::AlphaMode::blend;
    glass.base_color.a = 0.2f;
    glass.tint = tint;
    TestWorld world;
    world.environment = darkness();
    world.objects = {instance_of(model_of(sheet, wall), {3, 0, 0}, 1),
                     instance_of(model_of(sheet, glass), {2, 0, 0}, 2)};
    for (const world::Antialias antialias : {world::Antialias::none, world::Antialias::coverage}) {
        const TestCamera camera{
            .size = {16, 16}, .focal_px = 16, .antialias = antialias, .quality = world::Quality::beautiful};
        const auto found = draw(world, camera).at(8, 8);
        // Of what meets it squarely a pane mirrors 2 F / (1 + F), F = 0.04.
        for (glm::length_t c = 0; c < 3; ++c)
            EXPECT_NEAR(linear_of(found[static_cast<std::size_t>(c)]), 0.6 * 0.8 * (0.96 / 1.04) * tint[c], 0.006) << c;
    }
}

TEST(Quality, NormalMapsLeanAlongUAndAgainstVWithTheFilesTangentsOrWithout) {
    const glm::dvec3 towards = glm::normalize(glm::dvec3(-1.0, -0.8, 0.5));
    for (int variant = 0; variant < 16; ++variant) {
        const bool is_mirrored = variant & 1, has_tangents = variant & 2, is_reflected = variant & 4;
        const bool is_behind = variant & 8;  // the whole of the mapped normal is turned round (glTF 2.0, 3.9.4)
        for (const glm::dvec2 lean : {glm::dvec2(0.6, 0.0), glm::dvec2(0.0, 0.6)}) {
            // u to the right (-y), v down (-z); what is seen from behind, to the left.
            world::Primitive wall = rectangle({2, 0, 0}, {0, is_behind ? 4 : -4, 0}, {0, 0, 4});
            if (is_mirrored)
                for (glm::vec2& uv : wall.texcoords[0]) uv.x = -uv.x;
            const float along = is_mirrored ? -1.0f : 1.0f;
            if (has_tangents) wall.tangents.assign(4, glm::vec4(0, is_behind ? along : -along, 0, along));
            auto model = model_of(wall, surface(glm::vec3(0.5f), 1.0f));
            model->materials[0].double_sided = is_behind;
            if (is_reflected) model->nodes[0].matrix[1] *= -1.0;  // y turned round
            const auto code = [](double x) { return static_cast<std::uint8_t>(std::lround((x + 1.0) * 127.5)); };
            model->images.push_back({.size = {1, 1}, .rgba = {code(lean.x), code(lean.y), code(0.8), 255}});
            model->textures.push_back({.image = 0, .sampler = {}});
            model->materials[0].normal_texture = {.texture = 0};
            TestWorld world;
            world.environment = darkness();
            world.lights = {light_of(world::LightType::directional, 0.9f, {}, -towards)};
            world.objects = {instance_of(model)};
            const TestCamera camera{.size = {33, 33}, .focal_px = 32, .quality = world::Quality::beautiful};
            const double right = is_mirrored != is_reflected ? -1.0 : 1.0;
            const glm::dvec3 n(-0.8, -lean.x * right, is_behind ? -lean.y : lean.y);
            EXPECT_NEAR(linear_of(draw(world, camera).red(16, 16)),
                        0.9 * gltf_reflection(n, {-1, 0, 0}, towards, 0.5, 1.0, 0.0), 0.012)
                << is_mirrored << has_tangents << is_reflected << is_behind << lean.x;
        }
    }
}

/// A wall 10 m ahead, and a plate 6 m ahead, above what the camera sees of the wall's middle; the light comes from the
/// upper left, so that the plate's shadow falls 2 m lower and 2 m to the right.
TestWorld plate_and_wall(bool as_mover, world::LightType type) {
    TestWorld world;
    world.environment = darkness();
    const glm::dvec3 direction = glm::normalize(glm::dvec3(4.0, -2.0, -2.0));
    world.lights = {light_of(type, type == world::LightType::directional ? 0.8f : 200.0f,
                             glm::dvec3(6.0, 0.0, 2.0) - 6.0 * direction, direction)};
    world.lights[0].outer_cone_rad = 0.8f;
    world.lights[0].inner_cone_rad = 0.7f;
    world.objects = {
        instance_of(model_of(rectangle({10, 0, 0}, {0, -6, 0}, {0, 0, 6}), surface(glm::vec3(1.0f), 1.0f)))};
    auto& list = as_mover ? world.movers : world.objects;
    list.push_back(
        instance_of(model_of(rectangle({6, 0, 2}, {0, -0.5, 0}, {0, 0, 0.5}), colored(glm::vec3(0.5f))), {}, 2));
    return world;
}

const TestCamera wall_camera{.size = {640, 480}, .focal_px = 600.0, .quality = world::Quality::beautiful};

/// Where along a row (fractional pixel) the light falls below half of what it is at `x0`.
double falls_at(const Picture& picture, int y, int x0, int x1) {
    const double half = 0.5 * linear_of(picture.red(x0, y));
    for (int x = x0; x < x1; ++x) {
        const double a = linear_of(picture.red(x, y)), b = linear_of(picture.red(x + 1, y));
        if (a >= half && b < half) return x + (a - half) / (a - b);
    }
    return -1.0;
}

TEST(Shadow, EdgesLieWhereGeometrySaysWithinATexel) {
    struct Case {
        const char* name;
        world::LightType type;
        float cone_rad;
    };
    for (const Case& each :
         {Case{"sun", world::LightType::directional, 0.8f}, Case{"spot", world::LightType::spot, 0.8f},
          Case{"wide spot", world::LightType::spot, 1.5f}, Case{"point", world::LightType::point, 0.8f}}) {
        for (const bool as_mover : {false, true}) {
            TestWorld world = plate_and_wall(as_mover, each.type);
            world.lights[0].outer_cone_rad = each.cone_rad;
            const Picture picture = draw(world, wall_camera);
            // The plate's left edge is at y = 0.5, z = 2; followed along the light to x = 10.
            const bool is_sun = each.type == world::LightType::directional;
            const glm::dvec3 edge(6.0, 0.5, 2.0);
            const glm::dvec3 along = is_sun ? world.lights[0].direction : edge - world.lights[0].position;
            const glm::dvec3 hit = edge + along * (4.0 / along.x);
            const double expected = 319.5 - 600.0 * hit.y / 10.0;
            const int row = static_cast<int>(std::lround(239.5 - 600.0 * hit.z / 10.0));
            const double found =
                falls_at(picture, row, static_cast<int>(expected) - 30, static_cast<int>(expected) + 30);
            std::printf("%s %s: edge at %.3f, found %.3f\n", each.name, as_mover ? "mover" : "static", expected, found);
            EXPECT_NEAR(found, expected, 1.0);
        }
    }
}

/// Where the maps of a point light meet, a wall is as bright as its neighbours, and a shadow goes on.
TEST(Shadow, APointLightLeavesNoSeams) {
    TestWorld world;
    world.environment = darkness();
    // Of the wall at x = 10 the light, 1 m before it, sees the sides of its cube meet at y = +-1 and z = +-1.
    world.lights = {light_of(world::LightType::point, 0.8f, {9.0, 0.0, 0.0})};
    world.objects = {
        instance_of(model_of(rectangle({10, 0, 0}, {0, -6, 0}, {0, 0, 6}), surface(glm::vec3(1.0f), 1.0f)))};
    const auto lit = [](double y, double z) { return 0.8 / std::pow(1.0 + y * y + z * z, 1.5); };
    const auto place = [](int at, double middle) { return (middle - at) / 60.0; };
    const Picture open = draw(world, wall_camera);
    for (int y = 100; y < 380; ++y)
        for (int x = 180; x < 460; ++x)
            EXPECT_NEAR(open.red(x, y), srgb_code(lit(place(x, 319.5), place(y, 239.5))), 4) << x << " " << y;

    // A plate before the light, a tenth of the way to the wall: its shadow, 3 x 3 m, lies over four of the sides.
    world.movers = {
        instance_of(model_of(rectangle({9.1, 0, 0}, {0, -0.15, 0}, {0, 0, 0.15}), colored(glm::vec3(0.5f))), {}, 2)};
    const Picture shadowed = draw(world, wall_camera);
    for (int y = 100; y < 380; ++y)
        for (int x = 180; x < 460; ++x) {
            const double out = std::max(std::abs(place(x, 319.5)), std::abs(place(y, 239.5))) - 1.5;
            if (out < -1.2) continue;  // the plate itself
            if (out < -0.05) {
                EXPECT_LE(shadowed.red(x, y), 2) << x << " " << y;
            }
            if (out > 0.05) {
                EXPECT_EQ(shadowed.red(x, y), open.red(x, y)) << x << " " << y;
            }
        }
}

TEST(Shadow, LightsOutsideTheLevelBeautifulHaveNone) {
    for (const world::Quality quality : {world::Quality::fast, world::Quality::simple}) {
        TestCamera camera = wall_camera;
        camera.quality = quality;
        const Picture picture = draw(plate_and_wall(true, world::LightType::directional), camera);
        EXPECT_EQ(picture.red(440, 239), picture.red(500, 239));
    }
}

TEST(Shadow, FlatAndRoundSurfacesDoNotShadowThemselves) {
    for (int degrees = 5; degrees < 90; degrees += 6) {
        TestWorld world;
        world.environment = darkness();
        const double a = glm::radians(static_cast<double>(degrees));
        world.lights = {
            light_of(world::LightType::directional, 0.9f, {}, {std::cos(a), 0.6 * std::sin(a), -0.8 * std::sin(a)})};
        world.objects = {
            instance_of(model_of(rectangle({10, 0, 0}, {0, -6, 0}, {0, 0, 6}), surface(glm::vec3(1.0f), 1.0f)))};
        const Picture lit = draw(world, wall_camera);
        const int expected = srgb_code(0.9 * std::cos(a));
        int acne = 0;
        for (int y = 100; y < 380; ++y)
            for (int x = 100; x < 540; ++x) acne += lit.red(x, y) < expected - 12;
        EXPECT_EQ(acne, 0) << degrees;
    }
    // Of a ball, all that is lit by more than a few degrees.
    TestWorld world;
    world.environment = darkness();
    const glm::dvec3 towards = glm::normalize(glm::dvec3(-1.0, 0.5, 0.6));
    world.lights = {light_of(world::LightType::directional, 0.8f, {}, -towards)};
    world.objects = {instance_of(model_of(ball(), surface(glm::vec3(0.8f), 1.0f)), ball_at)};
    TestCamera camera = ball_camera;
    camera.quality = world::Quality::beautiful;
    const Picture picture = draw(world, camera);
    for_each_ball_pixel([&](int x, int y, glm::dvec3, glm::dvec3 n) {
        const double cosine = glm::dot(n, towards);
        if (cosine < 0.1) return;
        EXPECT_GT(linear_of(picture.red(x, y)), 0.55 * cosine) << x << " " << y;
    });
}

TEST(Shadow, BeginsWhereTheBodyTouchesTheGround) {
    // A box on the floor, the light from behind the camera and above: the shadow goes away from the camera, to the
    // left.
    TestWorld world;
    world.environment = darkness();
    world.lights = {light_of(world::LightType::directional, 0.9f, {}, glm::normalize(glm::dvec3(0.0, 1.0, -1.0)))};
    world.objects = {
        instance_of(model_of(rectangle({8, 0, -1}, {4, 0, 0}, {0, 4, 0}), surface(glm::vec3(1.0f), 1.0f))),
        instance_of(model_of(box({0.5f, 0.5f, 0.5f}), surface(glm::vec3(1.0f), 1.0f)), {8.0, 0.0, -0.5}, 2)};
    const Picture picture = draw(world, wall_camera);
    // On the floor beside the middle of the box: y from 0.5 (the box) to 1.5 (the end of the shadow), x = 7.6.
    const double row = 239.5 + 600.0 / 7.6;
    const auto column = [](double y) { return static_cast<int>(std::lround(319.5 - 600.0 * y / 7.6)); };
    int first_dark = 0;
    for (int x = column(0.5) + 2; x > column(1.4) && first_dark == 0; --x)
        if (linear_of(picture.red(x, static_cast<int>(row))) < 0.2) first_dark = x;
    const double gap_m = (column(0.5) - first_dark) / 600.0 * 7.6;
    std::printf("gap between a body and its shadow: %.3f m\n", gap_m);
    EXPECT_LT(gap_m, 0.05);
    EXPECT_GT(linear_of(picture.red(column(1.6), static_cast<int>(row))), 0.5);
}

TEST(Shadow, IsTheSameForEveryCameraAlone_OrWithOthers) {
    const world::SnapshotRef snapshot = plate_and_wall(true, world::LightType::directional).snapshot();
    const View one = wall_camera.view(21);
    TestCamera aside = wall_camera;
    aside.eye = {1.0, 2.0, 0.5};
    const View views[] = {aside.view(22), one, TestCamera{.quality = world::Quality::fast}.view(23)};
    const auto alone = draw_views(snapshot, {&one, 1});
    const auto together = draw_views(snapshot, views);
    EXPECT_TRUE(std::ranges::equal(alone.at(0)->bytes(), together.at(1)->bytes()));
}

TEST(Shadow, IsTheSameFarFromTheOrigin) {
    const Picture here = draw(plate_and_wall(true, world::LightType::directional), wall_camera);
    for (double distance = 1e3; distance <= 1e9; distance *= 100) {
        TestWorld there = plate_and_wall(true, world::LightType::directional);
        const glm::dvec3 offset = distance * glm::dvec3(1, -1, 1);
        for (auto* list : {&there.objects, &there.movers})
            for (world::Instance& each : *list) each.position += offset;
        TestCamera camera = wall_camera;
        camera.eye = offset;
        const Picture picture = draw(there, camera);
        int differ = 0;
        for (std::size_t i = 0; i < here.frame->bytes().size(); ++i)
            differ +=
                std::abs(static_cast<int>(here.frame->bytes()[i]) - static_cast<int>(picture.frame->bytes()[i])) > 1;
        EXPECT_LE(differ, 10) << distance;
    }
}

TEST(Shadow, AMaskCastsTheShadowOfItsHoles) {
    TestWorld world = plate_and_wall(false, world::LightType::directional);
    world::Material mask = colored(glm::vec3(0.5f));
    mask.alpha_mode = world::AlphaMode::mask;
    mask.base_color.a = 0.2f;
    world.objects[1] = instance_of(model_of(rectangle({6, 0, 2}, {0, -0.5, 0}, {0, 0, 0.5}), mask), {}, 2);
    const Picture picture = draw(world, wall_camera);
    EXPECT_EQ(picture.red(440, 239), picture.red(500, 239)) << "nothing but holes";
}

TEST(Shadow, OnlyTheBrightestFourLightsHaveOneAndAPointLightSeveral) {
    std::vector<world::Light> lights;
    for (int i = 0; i < 3; ++i)
        lights.push_back(light_of(world::LightType::spot, 10.0f + static_cast<float>(i), {0, 0, 5}));
    lights.push_back(light_of(world::LightType::point, 1000.0f));
    lights.push_back(light_of(world::LightType::directional, 0.0f));
    for (int i = 0; i < 2; ++i) lights.push_back(light_of(world::LightType::directional, 0.5f + static_cast<float>(i)));
    const WorldBox floor{glm::dvec3(-5, -5, -1), glm::dvec3(5, 5, 0)};
    const auto views = plan_shadows(lights, 1.0f, {&floor, 1});
    std::vector<std::size_t> chosen;
    for (const ShadowView& view : views) chosen.push_back(view.light);
    // The point light lies on the floor: five sides of its cube see that, and the sixth looks up.
    EXPECT_EQ(chosen, (std::vector<std::size_t>{6, 5, 3, 3, 3, 3, 3, 2}));
    lights.push_back(light_of(world::LightType::point, 900.0f, {0, 0, 1}));
    EXPECT_EQ(plan_shadows(lights, 1.0f, {&floor, 1}).size(), 8u) << "there is no room for a second one";
}

TEST(Shadow, MapsAreFinerWhereTheyWouldBeCoarseAndAreFew) {
    std::vector<world::Light> lights{light_of(world::LightType::directional, 1.0f),
                                     light_of(world::LightType::spot, 10.0f, {0, 0, 5})};
    const auto plan = [&](double half_m, bool with_local = true) {
        const WorldBox floor{glm::dvec3(-half_m, -half_m, -1), glm::dvec3(half_m, half_m, 0)};
        return plan_shadows(lights, 1.0f, {&floor, 1}, with_local);
    };
    const auto small = plan(10), large = plan(90);
    ASSERT_EQ(small.size(), 2u);
    ASSERT_EQ(large.size(), 2u);
    for (const ShadowView& view : small) EXPECT_EQ(view.side, shadow_map_side);
    for (const ShadowView& view : large) EXPECT_EQ(view.side, fine_shadow_map_side);
    EXPECT_NEAR(large[0].texel_m, 1.02 * 180.0 / fine_shadow_map_side, 1e-3);
    EXPECT_NEAR(large[1].texel_per_m / small[1].texel_per_m, double{shadow_map_side} / fine_shadow_map_side, 1e-12);
    EXPECT_EQ(plan(90, false).size(), 1u) << "baked light has that of the spot";
    lights.push_back(light_of(world::LightType::directional, 0.5f));
    const auto many = plan(90);
    ASSERT_EQ(many.size(), 3u);
    for (const ShadowView& view : many) EXPECT_EQ(view.side, shadow_map_side) << "memory";
}

TEST(Quality, DepthIdsAndNormalsAreTheSameBytesAtEveryLevel) {
    TestWorld world = plate_and_wall(true, world::LightType::directional);
    world.objects.push_back(instance_of(model_of(ball(), colored(glm::vec3(0.5f))), {6.0, 1.0, -0.5}, 3));
    const camera::Lens fisheye = make_lens(camera::LensModel::equidistant, std::vector{0.02, -0.01, 0.0, 0.0}).value();
    for (const camera::Lens& lens : {camera::Lens{}, fisheye}) {
        for (const world::Antialias antialias : {world::Antialias::automatic, world::Antialias::none}) {
            std::vector<std::vector<frame::FrameRef>> levels;
            for (const world::Quality quality : all_qualities) {
                View view = TestCamera{.size = {120, 90},
                                       .focal_px = lens == camera::Lens{} ? 100.0 : 30.0,
                                       .lens = lens,
                                       .antialias = antialias,
                                       .quality = quality}
                                .view();
                for (const frame::FrameKind kind :
                     {frame::FrameKind::depth, frame::FrameKind::instance, frame::FrameKind::normal})
                    view.kinds[static_cast<int>(kind)] = true;
                levels.push_back(draw_views(world.snapshot(), {&view, 1}));
            }
            for (std::size_t kind = 1; kind < 4; ++kind) {
                for (std::size_t level = 1; level < 3; ++level)
                    EXPECT_TRUE(std::ranges::equal(levels[0].at(kind)->bytes(), levels[level].at(kind)->bytes()))
                        << kind << " " << level;
            }
        }
    }
}

TEST(Quality, BeautifulShowsAreasUnlessTheCameraSaysOtherwise) {
    // A slanted bright edge before darkness: with one sample a pixel there are two values, with four there are five.
    TestWorld world;
    world.objects = {
        instance_of(model_of(rectangle({4, 0, 0}, {0, -1, 0.3}, {0, 0.3, 1}), colored(glm::vec3(1.0f), true)))};
    const auto values = [&](world::Quality quality, world::Antialias antialias) {
        const Picture picture = draw(world, {.antialias = antialias, .quality = quality});
        std::array<bool, 256> seen{};
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 64; ++x) seen[static_cast<std::size_t>(picture.red(x, y))] = true;
        return std::ranges::count(seen, true);
    };
    EXPECT_EQ(values(world::Quality::fast, world::Antialias::automatic), 2);
    EXPECT_EQ(values(world::Quality::simple, world::Antialias::automatic), 2);
    EXPECT_GT(values(world::Quality::beautiful, world::Antialias::automatic), 20);
    EXPECT_EQ(values(world::Quality::beautiful, world::Antialias::msaa4), 5);
    EXPECT_EQ(values(world::Quality::beautiful, world::Antialias::none), 2);
}

}  // namespace
}  // namespace camrig::render
