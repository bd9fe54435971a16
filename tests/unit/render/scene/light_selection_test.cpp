#include "core/render/scene/light_selection.h"

#include <gtest/gtest.h>

namespace camrig::render::scene {
namespace {

world::Light point(glm::dvec3 position, float intensity, float range = 0.0f) {
    world::Light light;
    light.type = world::LightType::point;
    light.position = position;
    light.intensity = intensity;
    light.range = range;
    return light;
}

TEST(LightSelection, LightsOutOfRangeOrDarkAreLeftOut) {
    const std::vector<world::Light> lights{point({0, 0, 5}, 1.0f, 4.5f), point({0, 0, 5}, 1.0f, 3.5f),
                                           point({0, 0, 1}, 0.0f)};
    const LightSet set = select_lights(lights, 1.0f, {0, 0, 0}, 1.0);
    EXPECT_EQ(set.local, 1);
    EXPECT_EQ(set.lights[0], 0);
}

TEST(LightSelection, AnUnlimitedLightIsLeftOutOnlyWhereItCannotBeSeen) {
    const world::Light lamp = point({0, 0, 0}, 1.0f);
    const double reach = reach_m(lamp, 1.0f);
    EXPECT_LT(255.0 * 12.92 / (reach * reach), 0.51);
    EXPECT_EQ(select_lights({&lamp, 1}, 1.0f, {reach + 0.9, 0, 0}, 1.0).local, 1);
    EXPECT_EQ(select_lights({&lamp, 1}, 1.0f, {reach + 1.1, 0, 0}, 1.0).local, 0);
}

TEST(LightSelection, ASpotThatShinesElsewhereIsLeftOut) {
    world::Light spot = point({0, 0, 3}, 5.0f);
    spot.type = world::LightType::spot;
    spot.outer_cone_rad = 0.5f;
    spot.direction = {0, 0, -1};
    EXPECT_EQ(select_lights({&spot, 1}, 1.0f, {0, 0, 0}, 0.1).local, 1);
    EXPECT_EQ(select_lights({&spot, 1}, 1.0f, {4, 0, 0}, 0.1).local, 0);
    EXPECT_EQ(select_lights({&spot, 1}, 1.0f, {4, 0, 0}, 3.0).local, 1);
    EXPECT_EQ(select_lights({&spot, 1}, 1.0f, {0, 0, 5}, 0.1).local, 0);
}

TEST(LightSelection, TheStrongestEightWinAndDirectionalOnesComeFirst) {
    std::vector<world::Light> lights;
    for (int i = 0; i < 12; ++i) lights.push_back(point({0, 0, 2.0 + i}, 1.0f));
    world::Light sun;
    sun.type = world::LightType::directional;
    lights.push_back(sun);
    const LightSet set = select_lights(lights, 1.0f, {0, 0, 0}, 0.5);
    EXPECT_EQ(set.directional, 1);
    EXPECT_EQ(set.local, 7);
    EXPECT_EQ(set.lights[0], 12);
    for (std::uint16_t i = 0; i < 7; ++i) EXPECT_EQ(set.lights[1 + i], i);
}

}  // namespace
}  // namespace camrig::render::scene
