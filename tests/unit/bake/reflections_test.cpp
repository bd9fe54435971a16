#include "core/bake/reflections.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/render/scene/light_sum.h"
#include "core/render/software/reflection_light.h"
#include "core/world/baked/baked_light_header.h"
#include "core/world/baked/shared_exponent.h"
#include "core/world/world.h"
#include "tests/unit/bake/scenes.h"

namespace camrig::bake {
namespace {

using render::scene::ReflectionMaps;
using render::software::IntLanes;
using render::software::Lanes;
using render::software::lanes;
using render::software::Lanes3;

/// A dark room with a mirror for a floor and a bright square of a metre on its east wall, from y = -0.5 to 0.5 and
/// z = 1 to 2 at x = 2.9.
constexpr double room_m = 6.0, panel_x = 2.9;
constexpr float panel_light = 3.0f;

world::SceneRef mirror_room(float roughness = 0.05f) {
    auto boxes = room({room_m, room_m, 3.0}, 0.0);
    boxes.push_back({"panel", {3.0, 0.0, 1.0}, {2 * (3.0 - panel_x), 1.0, 1.0}, 0.0});
    auto made = std::make_shared<world::Scene>(*scene_of(boxes));
    const auto change = [&](const std::string& name, const auto& how) {
        auto model = std::make_shared<world::Model>(*made->models.at(name).model);
        for (world::Material& material : model->materials) how(material);
        made->models.at(name).model = model;
    };
    change("floor", [&](world::Material& material) { material.roughness = roughness; });
    change("panel", [](world::Material& material) { material.emissive = glm::vec3(panel_light); });
    return made;
}

TEST(OctahedralMap, IsItsOwnInverseAndHasEachDirectionOnce) {
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    for (int i = 0; i < 10000; ++i) {
        const glm::vec3 direction = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
        const glm::vec2 at = world::octahedral_place(direction);
        ASSERT_LE(std::max(std::abs(at.x), std::abs(at.y)), 1.0f);
        ASSERT_LT(glm::distance(world::octahedral_direction(at), direction), 1e-5f);
    }
    EXPECT_EQ(world::octahedral_direction({0, 0}), glm::vec3(0, 0, 1));
    EXPECT_EQ(world::octahedral_direction({1, 1}), glm::vec3(0, 0, -1));
}

/// A probe that sees a smooth function of the direction.
TEST(ReflectionMaps, GoOnOverTheEdgesOfTheirSquares) {
    const auto value = [](const glm::vec3& d) { return glm::vec3(1.5f + d.x, 1.5f + d.y, 1.5f + d.z); };
    world::BakedLight light;
    light.reflection_probes.places = {glm::vec3(0.0f)};
    light.reflection_probes.nearness.assign(world::texels_of_nearness, 0);
    world::LightLayer& layer = light.layers.emplace_back();
    for (const world::ReflectionLevel& level : world::reflection_levels)
        for (int y = 0; y < level.side; ++y)
            for (int x = 0; x < level.side; ++x)
                layer.reflections.push_back(world::packed_light(value(world::octahedral_direction(
                    (glm::vec2(x, y) + 0.5f) * (2.0f / static_cast<float>(level.side)) - 1.0f))));
    const ReflectionMaps maps = render::scene::sum_reflections(light, {glm::vec3(2.0f)});
    ASSERT_EQ(maps.texels.size(), static_cast<std::size_t>(ReflectionMaps::start_of(1)));
    std::mt19937 random(2);
    std::normal_distribution<float> normal;
    for (std::int32_t level = 0; level < 4; ++level) {
        // What a straight line between texels is off by where the octahedron has an edge, and a code of nine bits.
        const double step = 3.2 / world::reflection_levels[static_cast<std::size_t>(level)].side;
        const double tolerance = 2.0 * (0.5 * step + 0.008);
        const auto seen_along = [&](const glm::vec3& d) {
            const Lanes3 seen = render::software::level_light<render::software::PlainIsa>(
                maps, IntLanes{}, IntLanes{} + level, {lanes(d.x), lanes(d.y), lanes(d.z)});
            return glm::vec3(seen.x[0], seen.y[0], seen.z[0]);
        };
        for (int i = 0; i < 2000; ++i) {
            // The two sides of an edge of the square are the same direction.
            const float across = 1e-4f, down = -0.2f - std::abs(normal(random)), along = normal(random);
            const auto gap_x = glm::abs(seen_along({across, along, down}) - seen_along({-across, along, down}));
            const auto gap_y = glm::abs(seen_along({along, across, down}) - seen_along({along, -across, down}));
            ASSERT_LT(glm::length(gap_x) + glm::length(gap_y), 0.02f) << level << " " << along << " " << down;
            glm::vec3 d(normal(random), normal(random), i % 3 == 0 ? -0.01f : normal(random));
            if (i % 5 == 0) d.x = 0.0f;
            d = glm::normalize(d);
            const glm::vec3 off = glm::abs(seen_along(d) - 2.0f * value(d));
            ASSERT_LT(std::max({off.x, off.y, off.z}), tolerance) << level << " " << d.x << " " << d.y << " " << d.z;
        }
    }
}

TEST(Reflections, ARayFromAnywhereMeetsWhatIsThere) {
    const auto scene = mirror_room();
    const world::BakedLight light = baked(scene, {.texels_per_m = 4.0, .rays = 32});
    ASSERT_FALSE(light.reflection_probes.places.empty());
    auto world = world::World::create(scene, 1);
    const render::scene::ProbeSights sights = render::scene::sights_of(light.reflection_probes);
    const ReflectionMaps maps = render::scene::sum_reflections(light, [&] {
        auto statics = std::make_shared<world::StaticSet>(*(*world)->snapshot(0)->statics);
        statics->baked_light = std::make_shared<const world::BakedLight>(light);
        return render::scene::layer_weights(*statics);
    }());
    const auto view = render::scene::reflections_in_view(maps, sights, {}, glm::vec3(1.0f));
    std::mt19937 random(3);
    std::uniform_real_distribution<float> place(-2.5f, 2.0f), unit(0.0f, 1.0f);
    int met = 0, of_met = 0, missed = 0, of_missed = 0;
    for (int i = 0; i < 12000; ++i) {
        // From the floor, to somewhere on the east wall.
        const glm::vec3 from(place(random), place(random), 0.0f);
        const glm::vec3 to(panel_x, 5.0f * unit(random) - 2.5f, 2.9f * unit(random));
        const glm::vec3 along = glm::normalize(to - from);
        const float beside = std::max(std::abs(to.y) - 0.5f, std::abs(to.z - 1.5f) - 0.5f);
        if (std::abs(beside) < 0.3f) continue;  // at most 20 cm: three texels of 3 degrees
        const Lanes3 way{lanes(along.x), lanes(along.y), lanes(along.z)};
        const Lanes3 seen = render::software::mirrored_light<render::software::PlainIsa>(
            view, {lanes(from.x), lanes(from.y), lanes(from.z)}, {way, way, lanes(1.0f), lanes(0.0f), lanes(0.04f)});
        const bool is_bright = seen.x[0] > 0.5f * panel_light;
        (beside < 0.0f ? of_met : of_missed)++;
        met += beside < 0.0f && is_bright;
        missed += beside > 0.0f && !is_bright;
    }
    ASSERT_GT(of_met, 50);
    ASSERT_GT(of_missed, 1000);
    EXPECT_GT(met, 0.95 * of_met);
    EXPECT_GT(missed, 0.98 * of_missed);
}

CAMRIG_WIDE void mirrored_light_wide(const render::scene::ReflectionsInView& view, const Lanes3& position,
                                     const render::software::Mirroring& of, Lanes3& to) {
    to = render::software::mirrored_light<render::software::Avx2Isa>(view, position, of);
}

TEST(Reflections, AreTheSameBytesWithBothInstructionSets) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") == 0) GTEST_SKIP() << "this processor has no AVX2";
#endif
    std::mt19937 random(4);
    std::uniform_int_distribution<std::uint32_t> word;
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
    ReflectionMaps maps;
    render::scene::ProbeSights sights;
    world::ReflectionProbes probes;
    for (int i = 0; i < 50; ++i) probes.places.emplace_back(4.0f * unit(random), 4.0f * unit(random), unit(random));
    sights.cells = render::scene::ProbeCells(probes.places);
    maps.texels.resize(static_cast<std::size_t>(ReflectionMaps::start_of(50)));
    for (std::uint32_t& texel : maps.texels) texel = word(random);
    sights.nearness.resize(probes.places.size() * render::scene::bordered_texels(world::nearness_side));
    for (float& nearness : sights.nearness) nearness = std::abs(unit(random));
    const auto view = render::scene::reflections_in_view(maps, sights, {}, glm::vec3(1.0f));
    const auto vector = [&](float scale) {
        Lanes3 made;
        for (Lanes* const lane : {&made.x, &made.y, &made.z})
            for (int k = 0; k < 8; ++k) (*lane)[k] = scale * unit(random);
        return made;
    };
    for (int i = 0; i < 2000; ++i) {
        const Lanes3 position = vector(5.0f);
        render::software::Mirroring of{vector(1.0f), vector(1.0f), vector(0.5f).x + 0.5f, vector(1.0f).x, lanes(0.04f)};
        // What no pixel shows may be anything.
        if (i % 10 == 0) of.view.x = position.x * std::numeric_limits<float>::quiet_NaN();
        of.roughness = i % 3 == 0 ? lanes(0.02f) : of.roughness * of.roughness;
        const Lanes3 plain = render::software::mirrored_light<render::software::PlainIsa>(view, position, of);
        Lanes3 wide;
        mirrored_light_wide(view, position, of, wide);
        if (i % 10 == 0) continue;
        ASSERT_EQ(std::memcmp(&plain, &wide, sizeof plain), 0) << i;
    }
}

TEST(Reflections, RougherSurfacesSpreadThem) {
    const auto scene = mirror_room();
    const world::BakedLight light = baked(scene, {.texels_per_m = 4.0, .rays = 32});
    const std::size_t glow = layer_of(light, world::LightSource::glow);
    const std::vector<std::uint32_t>& seen = light.layers[glow].reflections;
    // Light of a GGX lobe over directions is kept, its peak is not.
    float peak_before = 1e9f;
    double mean_first = 0.0;
    for (const std::size_t number : {world::mirror_level, std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
        const world::ReflectionLevel& level = world::reflection_levels[number];
        const std::size_t count = level.texels();
        std::size_t first = 0;
        for (std::size_t before = 0; before < number; ++before) first += world::reflection_levels[before].texels();
        float peak = 0.0f;
        double sum = 0.0, angles = 0.0;
        for (std::size_t i = 0; i < count; ++i) {
            const float value = world::unpacked_light(seen[first + i]).g;
            const std::size_t side = static_cast<std::size_t>(level.side);
            const glm::vec2 at =
                (glm::vec2(i % side, i / side) + 0.5f) * (2.0f / static_cast<float>(level.side)) - 1.0f;
            const glm::vec3 d = glm::abs(world::octahedral_direction(at));
            const double angle = std::pow(d.x + d.y + d.z, 3.0);  // a texel's solid angle goes with this
            peak = std::max(peak, value);
            sum += angle * value;
            angles += angle;
        }
        const double mean = sum / angles;
        EXPECT_LT(peak, peak_before * 1.001f);
        if (number == world::mirror_level) mean_first = mean;
        EXPECT_NEAR(mean, mean_first, 0.35 * mean_first) << level.side;
        peak_before = peak;
    }
    EXPECT_LT(peak_before, 0.5f * panel_light);
}

/// What is far away on all sides, from a function of the direction.
world::BakedLight light_of(const std::function<float(const glm::vec3&)>& light_along) {
    const auto look = [&](const Ray& ray, std::span<glm::vec3> by_layer) {
        by_layer[0] = glm::vec3(light_along(ray.along));
        return std::numeric_limits<float>::infinity();
    };
    const ReflectionView seen = reflection_view(glm::vec3(0.0f), world::levels_of_probe(0), 1, look);
    world::BakedLight light;
    light.reflection_probes = {{glm::vec3(0.0f)}, seen.nearness};
    world::LightLayer& layer = light.layers.emplace_back();
    for (const glm::vec3& texel : seen.texels[0]) layer.reflections.push_back(world::packed_light(texel));
    return light;
}

/// By very many halves between view and light (Walter et al., 2007), in doubles.
double mirrored_exactly(const glm::dvec3& view, double roughness,
                        const std::function<float(const glm::vec3&)>& light_along) {
    constexpr int count = 200;
    const double alpha = roughness * roughness, alpha2 = alpha * alpha;
    const auto lambda = [&](double z) { return 0.5 * (std::sqrt(1.0 + alpha2 * (1.0 - z * z) / (z * z)) - 1.0); };
    double sum = 0.0, weights = 0.0;
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k < count; ++k) {
            const double u = (i + 0.5) / count, angle = 2.0 * std::numbers::pi * (k + 0.5) / count;
            const double cosine = std::sqrt((1.0 - u) / (1.0 + (alpha2 - 1.0) * u)),
                         sine = std::sqrt(1.0 - cosine * cosine);
            const glm::dvec3 half(sine * std::cos(angle), sine * std::sin(angle), cosine);
            const double across = glm::dot(view, half);
            const glm::dvec3 way = 2.0 * across * half - view;
            if (across <= 0.0 || way.z <= 0.0) continue;
            const double fresnel = 0.04 + 0.96 * std::pow(1.0 - across, 5.0);
            const double weight = fresnel * across / cosine / (1.0 + lambda(view.z) + lambda(way.z));
            sum += weight * static_cast<double>(light_along(glm::vec3(way)));
            weights += weight;
        }
    }
    return sum / weights;
}

TEST(Reflections, SeenAslantAreAsLongAndAsNarrowAsMicrofacetsMakeThem) {
    // Posts and rails of light: what is stretched up and down shows the posts and not the rails.
    const auto posts = [](const glm::vec3& d) { return 1.0f + 0.8f * std::sin(16.0f * std::atan2(d.y, d.x)); };
    const auto rails = [](const glm::vec3& d) {
        return 1.0f + 0.8f * std::sin(10.0f * std::asin(glm::clamp(d.z, -1.0f, 1.0f)));
    };
    const std::function<float(const glm::vec3&)> all[] = {posts, rails};
    for (const auto& light_along : all) {
        const world::BakedLight light = light_of(light_along);
        const ReflectionMaps maps = render::scene::sum_reflections(light, {glm::vec3(1.0f)});
        const render::scene::ProbeSights sights = render::scene::sights_of(light.reflection_probes);
        const auto view = render::scene::reflections_in_view(maps, sights, {}, glm::vec3(1.0f));
        double squares = 0.0, most = 0.0, of_even = 0.0;
        int count = 0;
        for (const double roughness : {0.2, 0.35, 0.5}) {
            for (const double elevation_deg : {8.0, 15.0, 25.0, 40.0, 60.0}) {
                for (int i = 0; i < 24; ++i) {
                    const double elevation = elevation_deg * std::numbers::pi / 180.0,
                                 turn = 2.0 * std::numbers::pi * i / 24.3;
                    const glm::dvec3 eye(std::cos(elevation) * std::cos(turn), std::cos(elevation) * std::sin(turn),
                                         std::sin(elevation));
                    const auto vector = [](const glm::dvec3& v) {
                        return Lanes3{lanes(static_cast<float>(v.x)), lanes(static_cast<float>(v.y)),
                                      lanes(static_cast<float>(v.z))};
                    };
                    const Lanes rough = lanes(static_cast<float>(roughness));
                    const Lanes3 seen = render::software::mirrored_light<render::software::PlainIsa>(
                        view, Lanes3{},
                        {vector({0, 0, 1}), vector(eye), lanes(static_cast<float>(eye.z)), rough, lanes(0.04f)});
                    // As if seen along the normal.
                    const glm::dvec3 ray(-eye.x, -eye.y, eye.z);
                    const Lanes3 even = render::software::mirrored_light<render::software::PlainIsa>(
                        view, Lanes3{}, {vector(ray), vector(ray), lanes(1.0f), rough, lanes(0.04f)});
                    const double exact = mirrored_exactly(eye, roughness, light_along);
                    const double off = std::abs(static_cast<double>(seen.x[0]) - exact);
                    squares += off * off;
                    of_even += std::pow(static_cast<double>(even.x[0]) - exact, 2.0);
                    most = std::max(most, off);
                    ++count;
                }
            }
        }
        std::printf("rms %.4f, at most %.4f; evenly about the mirrored way: rms %.4f\n", std::sqrt(squares / count),
                    most, std::sqrt(of_even / count));
        EXPECT_LT(squares, 0.45 * of_even);
        EXPECT_LT(std::sqrt(squares / count), 0.08);
    }
}

TEST(ProbeCells, HaveTheTwoNearestOfAll) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
    for (const int count : {1, 2, 3, 40, 256}) {
        for (const glm::vec3& size :
             {glm::vec3(15, 10, 4), glm::vec3(0.2f), glm::vec3(5000, 1, 1), glm::vec3(1e8f, 1e8f, 1)}) {
            std::vector<glm::vec3> places;
            for (int i = 0; i < count; ++i)
                places.push_back(size * glm::vec3(unit(random), unit(random), unit(random)));
            const render::scene::ProbeCells cells(places);
            ASSERT_EQ(cells.size(), places.size());
            for (int i = 0; i < 300; ++i) {
                Lanes3 at;
                std::array<glm::vec3, 8> points;
                for (int lane = 0; lane < 8; ++lane) {
                    // Beyond them, too.
                    const glm::vec3 point = 1.3f * size * glm::vec3(unit(random), unit(random), unit(random));
                    points[static_cast<std::size_t>(lane)] = glm::vec3(glm::dvec3(point) - cells.first());
                    at.x[lane] = points[static_cast<std::size_t>(lane)].x;
                    at.y[lane] = points[static_cast<std::size_t>(lane)].y;
                    at.z[lane] = points[static_cast<std::size_t>(lane)].z;
                }
                IntLanes is_mirror{};
                for (int lane = 0; lane < 8; lane += 3) is_mirror[lane] = -1;
                const auto found = render::software::nearest_probes<render::software::PlainIsa>(cells, at, is_mirror);
                for (int lane = 0; lane < 8; ++lane) {
                    const auto distance = [&](std::size_t place) {
                        return glm::distance(
                            points[static_cast<std::size_t>(lane)],
                            glm::vec3(cells.places()[0][place], cells.places()[1][place], cells.places()[2][place]));
                    };
                    const std::size_t allowed =
                        std::min(places.size(), is_mirror[lane] != 0 ? world::most_mirror_probes : places.size());
                    std::vector<float> all;
                    for (std::size_t k = 0; k < allowed; ++k) all.push_back(distance(k));
                    std::ranges::sort(all);
                    ASSERT_LT(static_cast<std::size_t>(found.first[lane]), allowed);
                    ASSERT_FLOAT_EQ(distance(static_cast<std::size_t>(found.first[lane])), all[0])
                        << count << " " << size.x;
                    if (allowed > 1) {
                        ASSERT_LT(static_cast<std::size_t>(found.second[lane]), allowed);
                        ASSERT_FLOAT_EQ(distance(static_cast<std::size_t>(found.second[lane])), all[1])
                            << count << " " << size.x;
                    } else {
                        ASSERT_EQ(found.share[lane], 0.0f);
                    }
                }
            }
        }
    }
}

TEST(Reflections, StandWhereSomethingMirrorsAndNowhereElse) {
    EXPECT_TRUE(baked(mirror_room(0.9f), {.texels_per_m = 2.0, .rays = 16}).reflection_probes.places.empty());
    const auto light = baked(mirror_room(), {.texels_per_m = 2.0, .rays = 16, .reflections = 2});
    ASSERT_GE(light.reflection_probes.places.size(), 1u);
    ASSERT_LE(light.reflection_probes.places.size(), 2u);
    for (const glm::vec3& place : light.reflection_probes.places) {
        EXPECT_LT(std::max(std::abs(place.x), std::abs(place.y)), 0.5 * room_m);
        EXPECT_GT(place.z, 0.0f);
        EXPECT_LT(place.z, 3.0f);
    }
    EXPECT_TRUE(
        baked(mirror_room(), {.texels_per_m = 2.0, .rays = 16, .reflections = 0}).reflection_probes.places.empty());
}

TEST(Reflections, AreReadAsTheyWereWrittenAndBounded) {
    const auto scene = mirror_room();
    const world::BakedLight light = baked(scene, {.texels_per_m = 2.0, .rays = 16, .reflections = 2});
    const auto bytes = world::encode_baked_light(light);
    const auto read = world::decode_baked_light(bytes, *scene);
    ASSERT_TRUE(read.has_value()) << read.error().message;
    EXPECT_EQ((*read)->reflection_probes.places, light.reflection_probes.places);
    EXPECT_EQ((*read)->reflection_probes.nearness, light.reflection_probes.nearness);
    EXPECT_EQ((*read)->layers[0].reflections.size(),
              world::texels_of_reflections(light.reflection_probes.places.size()));
    EXPECT_EQ(world::encode_baked_light(**read), bytes);
    nlohmann::json text = world::baked_light_header(light);
    text["reflection_probes"] = std::vector<std::array<double, 3>>(world::max_reflection_probes + 1);
    EXPECT_FALSE(world::read_baked_light_header(text, *scene).has_value());
    text["reflection_probes"] = {{1, 2}};
    const auto wrong = world::read_baked_light_header(text, *scene);
    ASSERT_FALSE(wrong.has_value());
    EXPECT_NE(wrong.error().message.find("reflection_probes: places [x, y, z]"), std::string::npos)
        << wrong.error().message;
}

}  // namespace
}  // namespace camrig::bake
