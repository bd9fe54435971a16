#include <random>

#include <gtest/gtest.h>

#include "core/bake/ray_sampling.h"
#include "core/render/scene/view_lights.h"
#include "core/world/baked/light_bytes.h"

namespace camrig::bake {
namespace {

using world::LightProbe;

constexpr int direction_count = 20000;

/// On a surface with that normal, in units of shading: irradiance over pi.
template <typename Light>
double counted(const Light& light, const glm::vec3& normal) {
    double sum = 0.0;
    for (int i = 0; i < direction_count; ++i) {
        const glm::vec3 from = to_all_sides(spread_point(i, {}));
        sum += 4.0 * light(from) * std::max(0.0, static_cast<double>(glm::dot(from, normal)));
    }
    return sum / direction_count;
}

/// As both renderers have it.
glm::vec3 on(const LightProbe& probe, const glm::vec3& normal) {
    glm::vec3 light = probe.mean + probe.along * normal;
    const auto products = world::products_of(normal);
    for (std::size_t i = 0; i < products.size(); ++i) light += probe.products[i] * products[i];
    return light;
}

template <typename Light>
LightProbe probe_of(const Light& light) {
    LightProbe probe;
    for (int i = 0; i < direction_count; ++i) {
        const glm::vec3 from = to_all_sides(spread_point(i, {}));
        probe.add(glm::vec3(static_cast<float>(light(from) / direction_count)), from);
    }
    return probe;
}

glm::vec3 any_direction(std::mt19937& random) {
    std::normal_distribution<float> at;
    return glm::normalize(glm::vec3(at(random), at(random), at(random)));
}

TEST(LightProbe, HasLightThatChangesSmoothlyWithDirectionExactly) {
    const auto light = [](const glm::vec3& v) {
        return 1.0 + 0.4 * v.x - 0.3 * v.z + 0.5 * v.x * v.y - 0.4 * v.y * v.z + 0.3 * v.x * v.z +
               0.25 * (v.x * v.x - v.y * v.y) + 0.2 * (3.0 * v.z * v.z - 1.0);
    };
    const LightProbe probe = probe_of(light);
    std::mt19937 random(1);
    for (int i = 0; i < 50; ++i) {
        const glm::vec3 normal = any_direction(random);
        EXPECT_NEAR(on(probe, normal).g, counted(light, normal), 3e-3) << i;
    }
}

// What is bright above and below, as a hall is, leaves walls and people darker than the mean is.
TEST(LightProbe, KnowsThatLightFromAboveAndBelowLeavesSidesDark) {
    const auto light = [](const glm::vec3& v) { return std::abs(v.z) > 0.8f ? 1.0 : 0.1; };
    const LightProbe probe = probe_of(light);
    for (const glm::vec3 normal : {glm::vec3(1, 0, 0), glm::vec3(0, -1, 0), glm::vec3(0, 0, 1), glm::vec3(0, 0, -1)})
        EXPECT_NEAR(on(probe, normal).g, counted(light, normal), 0.03);
    EXPECT_LT(on(probe, {1, 0, 0}).g, 0.75f * probe.mean.g);
}

TEST(LightProbe, OfOneDirectionIsNotFarFromItsCosine) {
    std::mt19937 random(2);
    float worst = 0.0f;
    for (int i = 0; i < 2000; ++i) {
        const glm::vec3 towards = any_direction(random), normal = any_direction(random);
        LightProbe probe;
        probe.add(glm::vec3(0.25f), towards);
        worst = std::max(worst, std::abs(on(probe, normal).g - std::max(0.0f, glm::dot(normal, towards))));
    }
    // 1/4 - 5/32 across it.
    EXPECT_LT(worst, 0.094f);
}

LightProbe any_probe(std::mt19937& random) {
    LightProbe probe;
    std::uniform_real_distribution<float> strength(0.0f, 2.0f);
    for (int i = 0; i < 6; ++i)
        probe.add({strength(random), strength(random), strength(random)}, any_direction(random));
    return probe;
}

TEST(LightProbe, AddsUp) {
    std::mt19937 random(5);
    const LightProbe one = any_probe(random), other = any_probe(random);
    const glm::vec3 by(0.5f, 2.0f, 3.0f);
    LightProbe sum = one.scaled(by);
    sum += other;
    for (int i = 0; i < 10; ++i) {
        const glm::vec3 normal = any_direction(random);
        const glm::vec3 expected = on(one, normal) * by + on(other, normal), is = on(sum, normal);
        for (glm::length_t c = 0; c < 3; ++c) EXPECT_NEAR(is[c], expected[c], 1e-4) << i;
    }
}

TEST(LightProbe, IsTheSameInTheFrameOfAView) {
    std::mt19937 random(3);
    for (int i = 0; i < 20; ++i) {
        const LightProbe probe = any_probe(random);
        render::ViewTransform view;
        const glm::vec3 axis = any_direction(random);
        view.optical_from_world = glm::mat3_cast(glm::angleAxis(0.3 * i, glm::dvec3(axis)));
        const LightProbe seen = render::scene::surroundings_in_view(probe, view);
        for (int k = 0; k < 10; ++k) {
            const glm::vec3 normal = any_direction(random);
            const glm::vec3 there = on(seen, glm::mat3(view.optical_from_world) * normal), here = on(probe, normal);
            for (glm::length_t c = 0; c < 3; ++c) EXPECT_NEAR(there[c], here[c], 1e-5) << i;
        }
    }
}

TEST(LightProbe, IsReadAsItWasWritten) {
    std::mt19937 random(4);
    std::vector<LightProbe> probes(50);
    for (LightProbe& probe : probes) probe = any_probe(random);
    const std::vector<LightProbe> read = world::unpack_light_probes(world::pack_light_probes(probes));
    ASSERT_EQ(read.size(), probes.size());
    for (std::size_t i = 0; i < probes.size(); ++i) {
        const glm::vec3 normal = any_direction(random);
        const glm::vec3 was = on(probes[i], normal), is = on(read[i], normal);
        for (glm::length_t c = 0; c < 3; ++c) EXPECT_NEAR(is[c], was[c], 0.012 * probes[i].mean[c]) << i;
    }
}

}  // namespace
}  // namespace camrig::bake
