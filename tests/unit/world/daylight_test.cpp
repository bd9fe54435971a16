#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <span>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/world/daylit.h"
#include "core/world/scene.h"
#include "core/world/scene_check.h"
#include "tests/temporary_folder.h"
#include "tests/unit/world/world_fixture.h"

namespace camrig::world {
namespace {

using namespace world_test;
using nlohmann::json;
using testing::HasSubstr;

/// A scene file in a folder that this process has to itself.
std::filesystem::path written(const json& scene, const char* name = "scene.json") {
    static const TemporaryFolder folder;
    std::ofstream(folder / name) << scene;
    return folder / name;
}
json by_day(json daylight) {
    return {{"camrig_scene", 1},
            {"name", "day"},
            {"environment", {{"daylight", std::move(daylight)}}},
            {"models", {{"sky", {{"shape", "sky"}}}, {"box", {{"shape", "box"}}}}},
            {"objects", {{{"name", "sky"}, {"model", "sky"}}, {{"name", "box"}, {"model", "box"}}}}};
}
glm::vec3 zenith_of(const Model& sky) {
    const Primitive& sphere = sky.meshes[0].primitives[0];
    const auto top = std::ranges::max_element(sphere.positions, {}, &glm::vec3::y) - sphere.positions.begin();
    return glm::vec3(sphere.colors[static_cast<std::size_t>(top)]);
}

TEST(Daylight, MakesTheSunTheSkyAndTheBackgroundInLux) {
    const auto scene = load_scene(written(by_day({{"azimuth_deg", 90}, {"elevation_deg", 60}})));
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_EQ((*scene)->lights.size(), 1u);
    const Light& sun = (*scene)->lights[0];
    EXPECT_EQ(sun.name, "sun");
    EXPECT_EQ(sun.type, LightType::directional);
    EXPECT_LT(glm::distance(sun.direction, glm::dvec3(-0.5, 0, -std::sqrt(0.75))), 1e-9) << "in the east, which is x";
    // About 93 klx face to face, 22 klx of sky: white is 100 klx.
    EXPECT_NEAR(sun.color.g * sun.intensity, 0.93, 0.03);
    EXPECT_GT(sun.color.r, sun.color.b);
    const Environment& around = (*scene)->environment;
    EXPECT_NEAR(around.ambient_sky.g, 0.22, 0.03);
    EXPECT_NEAR(around.ambient_ground.g,
                0.25f * (around.ambient_sky.g + std::sqrt(0.75f) * sun.color.g * sun.intensity), 1e-5);
    EXPECT_EQ(around.lux, daylight_lux);
    EXPECT_GT(zenith_of(*(*scene)->models.at("sky").model).b, zenith_of(*(*scene)->models.at("sky").model).r);
}

TEST(Daylight, OfATimeAndAPlaceIsThatOfTheSunThere) {
    // Noon of the solstice near 16.4 degrees east: the sun stands in the south, 90 - 48.2 + 23.4 degrees high.
    const auto scene = load_scene(written(
        by_day({{"time", "2026-06-21T10:56:00Z"}, {"latitude_deg", 48.2}, {"longitude_deg", 16.4}, {"north_deg", 0}})));
    ASSERT_TRUE(scene) << scene.error().message;
    const glm::dvec3 to_sun = -(*scene)->lights[0].direction;
    EXPECT_NEAR(glm::degrees(std::asin(to_sun.z)), 65.2, 0.2);
    EXPECT_LT(to_sun.x, -0.4) << "north is x, so the south is behind it";
    EXPECT_NEAR(to_sun.y, 0.0, 0.02);
}

TEST(Daylight, TakesTheSunThatIsThereAndLeavesItsLux) {
    json file = by_day({{"azimuth_deg", 180}, {"elevation_deg", 30}});
    file["environment"]["lux"] = 20000;
    file["lights"] = {{{"name", "lamp"}, {"type", "point"}, {"position", {0, 0, 3}}},
                      {{"name", "sun"}, {"type", "directional"}, {"direction", {0, 0, -1}}, {"intensity", 9}}};
    file["events"] = {{{"name", "eclipse"},
                       {"when", {{"at_s", 1}}},
                       {"do", {{{"action", "light"}, {"light", "sun"}, {"intensity", 0}}}}}};
    const auto scene = load_scene(written(file));
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_EQ((*scene)->lights.size(), 2u);
    EXPECT_NEAR((*scene)->lights[1].direction.z, -0.5, 1e-9);
    EXPECT_NEAR((*scene)->lights[1].color.g * (*scene)->lights[1].intensity, 77e3 / 20e3, 0.2);
}

TEST(Daylight, WhatIsWrongIsSaidWhereItIs) {
    const auto message = [](json daylight) { return load_scene(written(by_day(std::move(daylight)))).error().message; };
    EXPECT_THAT(message(json::object()), HasSubstr("environment.daylight.azimuth_deg: is missing; or give time"));
    EXPECT_THAT(message({{"azimuth_deg", 1}, {"elevation_deg", 91}}),
                HasSubstr("environment.daylight.elevation_deg: "));
    EXPECT_THAT(message({{"azimuth_deg", 1}, {"elevation_deg", 2}, {"time", "2026-01-01T00:00Z"}}),
                HasSubstr("give either time or azimuth_deg and elevation_deg"));
    EXPECT_THAT(message({{"time", "noon"}, {"latitude_deg", 1}, {"longitude_deg", 2}}),
                HasSubstr("environment.daylight.time: noon: expected a time as 2026-06-21T14:30:00+02:00"));
    EXPECT_THAT(message({{"time", "2026-01-01T00:00Z"}, {"latitude_deg", 1}}),
                HasSubstr("environment.daylight.longitude_deg: is missing beside time"));
    EXPECT_THAT(message({{"azimuth_deg", 1}, {"elevation_deg", 2}, {"turbidity", 1}}), HasSubstr("turbidity: "));
    json both = by_day({{"azimuth_deg", 1}, {"elevation_deg", 2}});
    both["environment"]["background"] = {0, 0, 0};
    EXPECT_THAT(load_scene(written(both)).error().message,
                HasSubstr("environment.background: is made by environment.daylight; leave one of them out"));
}

TEST(Daylight, GoesOnByEventsAndAtOnce) {
    const auto scene = load_scene(written(by_day({{"azimuth_deg", 90}, {"elevation_deg", 60}})));
    ASSERT_TRUE(scene);
    auto changed = std::make_shared<Scene>(**scene);
    changed->events = {event(R"({"name": "dusk", "when": {"at_s": 1}, "do": [{"action": "environment", "exposure": 9,
                                 "daylight": {"azimuth_deg": 300, "elevation_deg": -3}}]})")};
    auto world = World::create(changed, 1).value();
    world->advance_to(0);
    const auto noon = world->snapshot(0)->statics;
    world->advance_to(2 * ns_per_s);
    const auto dusk = world->snapshot(2 * ns_per_s)->statics;
    EXPECT_EQ(dusk->lights[0].intensity, 0.0f) << "it has set";
    EXPECT_LT(dusk->environment.ambient_sky.g, 0.01f * noon->environment.ambient_sky.g);
    EXPECT_EQ(dusk->environment.exposure, 9.0f);
    EXPECT_LT(zenith_of(*dusk->objects[0].info->model).g, 0.01f * zenith_of(*noon->objects[0].info->model).g);
    EXPECT_EQ(dusk->objects[0].info->id, noon->objects[0].info->id);
    EXPECT_EQ(dusk->objects[1].info, noon->objects[1].info) << "nothing but the sky";

    const EventSpec back = event(R"({"name": "x", "when": {"at_s": 99}, "do": [{"action": "environment",
                                     "daylight": {"azimuth_deg": 90, "elevation_deg": 60}}]})");
    const StateHash before = world->state_hash();
    ASSERT_TRUE(world->act(back.actions));
    EXPECT_NE(world->state_hash().value, before.value);
    EXPECT_EQ(world->snapshot(2 * ns_per_s)->statics->lights[0].intensity, noon->lights[0].intensity);
}

/// A sky alone, of a daylight.
ModelRef sky_by(json daylight) {
    const auto scene = load_scene(written(by_day(std::move(daylight))));
    return scene ? (*scene)->models.at("sky").model : nullptr;
}
/// What is seen at a texel of the sky's picture: its factor, linear, on the colour of the nearest corner.
glm::dvec3 seen_at(const Model& sky, int column, int row) {
    const Image& picture = sky.images.at(0);
    const Primitive& sphere = sky.meshes[0].primitives[0];
    const glm::vec2 uv((column + 0.5f) / picture.size.width, (row + 0.5f) / picture.size.height);
    const auto nearest = std::ranges::min_element(sphere.texcoords[0], {},
                                                  [&](const glm::vec2& corner) { return glm::distance(corner, uv); });
    const glm::dvec3 most(sphere.colors[static_cast<std::size_t>(nearest - sphere.texcoords[0].begin())]);
    glm::dvec3 factor;
    for (int i = 0; i < 3; ++i) {
        const double code = picture.rgba[static_cast<std::size_t>(4 * (row * picture.size.width + column) + i)] / 255.0;
        factor[i] = code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
    }
    return most * factor;
}

TEST(Clouds, AreNoneWithoutAShareAndTheSkyIsAsItWas) {
    const json day{{"azimuth_deg", 90}, {"elevation_deg", 40}};
    const auto with = [&](const json& more) {
        json all = day;
        all.update(more);
        return sky_by(all);
    };
    const ModelRef plain = with(json::object()), none = with({{"clouds", 0}});
    const ModelRef closed = with({{"overcast", 1}}), covered = with({{"clouds", 1}});
    const ModelRef veiled = with({{"overcast", 0.5}, {"clouds", 0}});
    for (const ModelRef& sky : {plain, none, closed, covered, veiled}) {
        ASSERT_TRUE(sky);
        EXPECT_TRUE(sky->images.empty());
        EXPECT_EQ(sky->materials[0].base_color_texture.texture, -1);
        for (const glm::vec2& uv : sky->meshes[0].primitives[0].texcoords[0]) ASSERT_EQ(uv, glm::vec2(0.0f));
    }
    const auto colors = [](const ModelRef& sky) { return sky->meshes[0].primitives[0].colors; };
    EXPECT_EQ(colors(plain), colors(none));
    EXPECT_NE(colors(plain), colors(veiled));
    // Above the horizon; below it is what the light of the scene makes of it.
    const auto above = [&](const ModelRef& sky) {
        const auto all = colors(sky);
        return std::vector(all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2 + 49), all.end());
    };
    EXPECT_EQ(above(closed), above(covered));
    EXPECT_THAT(
        load_scene(written(by_day({{"azimuth_deg", 1}, {"elevation_deg", 2}, {"clouds", 1.5}}))).error().message,
        HasSubstr("environment.daylight.clouds: "));
}

TEST(Clouds, AreAPictureOnTheSkyAndNothingElseOfTheScene) {
    const json day{{"azimuth_deg", 90}, {"elevation_deg", 40}};
    json clouded = day;
    clouded["clouds"] = 0.4;
    const auto clear = load_scene(written(by_day(day))), scene = load_scene(written(by_day(clouded)));
    ASSERT_TRUE(clear && scene);
    EXPECT_EQ((*scene)->environment.ambient_sky, (*clear)->environment.ambient_sky);
    EXPECT_EQ((*scene)->environment.background, (*clear)->environment.background);
    EXPECT_EQ((*scene)->lights[0].intensity, (*clear)->lights[0].intensity);

    const Model& sky = *(*scene)->models.at("sky").model;
    ASSERT_EQ(sky.images.size(), 1u);
    const Image& picture = sky.images[0];
    const auto first_row = std::span(picture.rgba).first(static_cast<std::size_t>(4 * picture.size.width));
    EXPECT_TRUE(std::ranges::all_of(first_row, [](std::uint8_t code) { return code == 255; })) << "of all below";
    const Primitive& sphere = sky.meshes[0].primitives[0];
    const Primitive& before = (*clear)->models.at("sky").model->meshes[0].primitives[0];
    ASSERT_EQ(sphere.positions, before.positions);
    std::size_t below = 0;
    for (std::size_t i = 0; i < sphere.positions.size(); ++i) {
        if (sphere.positions[i].y > 1e-4f) continue;
        ++below;
        ASSERT_EQ(sphere.texcoords[0][i].y, 0.0f);
        ASSERT_LT(glm::distance(sphere.colors[i], before.colors[i]), 1e-6f);
    }
    EXPECT_GT(below, sphere.positions.size() / 2);

    // Beside its seam the picture is as smooth as elsewhere.
    const auto step = [&](int column) {
        double sum = 0.0;
        for (int row = 0; row < picture.size.height; ++row) {
            const auto code = [&](int at) {
                return int{picture.rgba[static_cast<std::size_t>(4 * (row * picture.size.width + at))]};
            };
            sum += std::abs(code(column) - code((column + 1) % picture.size.width));
        }
        return sum;
    };
    double most = 0.0;
    for (int column = 0; column < picture.size.width - 1; ++column) most = std::max(most, step(column));
    EXPECT_LE(step(picture.size.width - 1), most);
    // The same again, byte for byte.
    EXPECT_EQ(sky_by(clouded)->images[0].rgba, picture.rgba);
}

/// The factor of the sky's picture anywhere, linear: between texels as renderers filter.
glm::dvec3 factor_at(const Image& picture, const glm::vec2& uv) {
    const glm::dvec2 at = glm::dvec2(uv) * glm::dvec2(picture.size.width, picture.size.height) - 0.5;
    glm::dvec3 sum(0.0);
    for (int corner = 0; corner < 4; ++corner) {
        const glm::dvec2 first = glm::floor(at), share = at - first;
        const int dx = corner % 2, dy = corner / 2;
        const int column = (static_cast<int>(first.x) + dx + picture.size.width) % picture.size.width;
        const int row = std::clamp(static_cast<int>(first.y) + dy, 0, picture.size.height - 1);
        const double weight = (dx == 1 ? share.x : 1.0 - share.x) * (dy == 1 ? share.y : 1.0 - share.y);
        for (int i = 0; i < 3; ++i) {
            const double code =
                picture.rgba[static_cast<std::size_t>(4 * (row * picture.size.width + column) + i)] / 255.0;
            sum[i] += weight * (code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4));
        }
    }
    return sum;
}

TEST(Clouds, LeaveTheSkyBesideThemAsItIsBetweenTheCornersToo) {
    // A low sun in haze: colours change fastest from corner to corner.
    const json day{{"azimuth_deg", 90}, {"elevation_deg", 5}, {"turbidity", 10}};
    json clouded = day;
    clouded["clouds"] = 0.02;
    const ModelRef plain = sky_by(day), sky = sky_by(clouded);
    const Primitive &before = plain->meshes[0].primitives[0], &sphere = sky->meshes[0].primitives[0];
    std::vector<double> errors;
    for (std::size_t i = 0; i + 1 < sphere.positions.size(); ++i) {
        const glm::vec2 &uv = sphere.texcoords[0][i], &next = sphere.texcoords[0][i + 1];
        if (uv.y < 0.1f || uv.y > 0.9f || uv.y != next.y) continue;
        const auto mixed = [&](const Primitive& of) {
            return 0.5 * (glm::dvec3(of.colors[i]) + glm::dvec3(of.colors[i + 1]));
        };
        const glm::dvec3 seen = mixed(sphere) * factor_at(sky->images[0], 0.5f * (uv + next));
        errors.push_back(std::abs(seen.g / mixed(before).g - 1.0));
    }
    std::ranges::sort(errors);
    ASSERT_GT(errors.size(), 1000u);
    EXPECT_LT(errors[errors.size() * 9 / 10], 0.005) << "of all but where there are clouds";
}

TEST(Clouds, AreBrightByDayColouredInTheEveningAndDarkAtNight) {
    /// Means over the half of the sky away from the sun in the east, 15 to 50 degrees up: of the brightest tenth of a
    /// sky, and of all of it.
    const auto seen = [](double elevation_deg, double clouds) {
        const ModelRef sky = sky_by({{"azimuth_deg", 90}, {"elevation_deg", elevation_deg}, {"clouds", clouds}});
        std::vector<glm::dvec3> all;
        for (int row = 104; row < 190; row += 6)
            for (int column = 640; column < 1408; column += 16) all.push_back(seen_at(*sky, column, row));
        std::ranges::sort(all, std::greater(), [](const glm::dvec3& color) { return color.g; });
        const auto mean = [&](std::size_t count) {
            glm::dvec3 sum(0.0);
            for (std::size_t i = 0; i < count; ++i) sum += all[i];
            return sum / double(count);
        };
        return std::pair(mean(all.size() / 10), mean(all.size()));
    };
    const auto noon = seen(55, 0.35), few = seen(55, 0.001), dusk = seen(2, 0.35), night = seen(-20, 0.35);
    EXPECT_GT(noon.first.g, 2.0 * few.first.g) << "white before blue";
    EXPECT_GT(noon.first.r / noon.first.b, 1.2 * few.second.r / few.second.b);
    EXPECT_LT(noon.first.g, 1.0) << "no whiter than paper in the sun";
    EXPECT_GT(dusk.first.r, 1.3 * dusk.first.b);
    EXPECT_LT(night.first.g, 1e-6 * noon.first.g);
}

TEST(Clouds, ComeByEvents) {
    const auto scene = load_scene(written(by_day({{"azimuth_deg", 90}, {"elevation_deg", 60}})));
    ASSERT_TRUE(scene);
    auto world = World::create(std::make_shared<Scene>(**scene), 1).value();
    world->advance_to(0);
    const StateHash before = world->state_hash();
    ASSERT_TRUE(world->act(event(R"({"name": "x", "when": {"at_s": 99}, "do": [{"action": "environment",
                                     "daylight": {"azimuth_deg": 90, "elevation_deg": 60, "clouds": 0.3}}]})")
                               .actions));
    EXPECT_EQ(world->snapshot(0)->statics->objects[0].info->model->images.size(), 1u);
    EXPECT_NE(world->state_hash().value, before.value);
}

TEST(Act, DaylightLeavesTheOtherLightsTheirNumbers) {
    auto world = World::create(empty_scene(), 1).value();
    world->advance_to(0);
    const auto lights = [&] { return world->snapshot(0)->statics->lights; };
    const std::string first = lights().at(0).name;
    const std::size_t before = lights().size();
    ASSERT_TRUE(world->act(event(R"({"name": "x", "when": {"at_s": 99}, "do": [{"action": "environment",
                                     "daylight": {"azimuth_deg": 90, "elevation_deg": 60}}]})")
                               .actions));
    EXPECT_EQ(lights().at(0).name, first) << "baked light counts them";
    ASSERT_EQ(lights().size(), before + 1);
    EXPECT_EQ(lights().back().name, sun_name);
    EXPECT_GT(lights().back().intensity, 0.0f);
}

TEST(Act, DoesWhatAnEventWouldOrNothingWhereANameIsUnknown) {
    auto scene = empty_scene();
    auto world = World::create(scene, 1).value();
    world->advance_to(ns_per_s);
    const auto actions = [](const char* text) {
        return event((std::string(R"({"name": "x", "when": {"at_s": 99}, "do": )") + text + "}").c_str()).actions;
    };
    ASSERT_TRUE(world->act(actions(R"([{"action": "light", "light": "lamp", "intensity": 0.5},
                                       {"action": "user", "data": 7}])")));
    EXPECT_EQ(world->snapshot(ns_per_s)->statics->lights[0].intensity, 0.5f);
    const auto records = world->take_records();
    ASSERT_EQ(records.size(), 1u);
    EXPECT_EQ(records[0].event, "event.act");
    EXPECT_THAT(records[0].data, testing::ElementsAre("7"));

    const auto refused = world->act(actions(R"([{"action": "light", "light": "lamp", "intensity": 3},
                                                {"action": "light", "light": "lump", "intensity": 3}])"));
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, HasSubstr("do[1].light: no light 'lump'"));
    EXPECT_EQ(world->snapshot(ns_per_s)->statics->lights[0].intensity, 0.5f) << "nothing was done";
    EXPECT_TRUE(world->take_records().empty());
}

TEST(Act, SetsLightsInTheUnitsOfAPhotometricScene) {
    auto scene = empty_scene();
    scene->lights.assign(2, {});
    scene->lights[0].name = "lamp", scene->lights[0].type = LightType::point;
    scene->lights[1].name = "moon", scene->lights[1].type = LightType::directional;
    const auto act = [&](World& world, const char* action) {
        return world.act(
            event((std::string(R"({"name": "x", "when": {"at_s": 99}, "do": [{"action": "light", )") + action + "}]}")
                      .c_str())
                .actions);
    };
    const auto message_of = [](const auto& result) { return result ? std::string() : result.error().message; };
    auto without = World::create(scene, 1).value();
    EXPECT_THAT(message_of(act(*without, R"("light": "lamp", "candela": 300)")),
                HasSubstr("do[0].candela: needs environment.lux"));
    scene->environment.lux = 200.0;
    auto world = World::create(scene, 1).value();
    ASSERT_TRUE(act(*world, R"("light": "lamp", "candela": 300)"));
    ASSERT_TRUE(act(*world, R"("light": "moon", "lux": 50)"));
    world->advance_to(ns_per_s);
    EXPECT_FLOAT_EQ(world->snapshot(ns_per_s)->statics->lights[0].intensity, 1.5f);
    EXPECT_FLOAT_EQ(world->snapshot(ns_per_s)->statics->lights[1].intensity, 0.25f);
    EXPECT_THAT(message_of(act(*world, R"("light": "lamp", "lux": 5)")),
                HasSubstr("do[0].lux: 'lamp' is a lamp, give candela"));
    EXPECT_THAT(message_of(act(*world, R"("light": "moon", "candela": 5)")),
                HasSubstr("do[0].candela: 'moon' is a directional light, give lux"));
    const auto twice = json::parse(R"({"name": "x", "when": {"at_s": 99},
                                       "do": [{"action": "light", "light": "lamp", "lux": 5, "intensity": 1}]})");
    JsonReader reader(twice, "");
    EXPECT_THAT(message_of(read_event(reader)), HasSubstr("do[0].intensity: give one of intensity, candela and lux"));
}

TEST(Act, SwitchesLampsOfAGroupTogetherAndNoneAlone) {
    auto scene = empty_scene();
    scene->lights.clear();
    for (const char* name : {"a", "b"}) scene->lights.push_back({.name = name, .group = "lamps"});
    auto world = World::create(scene, 1).value();
    world->advance_to(ns_per_s);
    const auto act = [&](const char* text) {
        return world->act(
            event((std::string(R"({"name": "x", "when": {"at_s": 99}, "do": [)") + text + "]}").c_str()).actions);
    };
    const auto lights = [&](TimeNs t) {
        world->advance_to(t);
        return world->snapshot(t)->statics->lights;
    };
    ASSERT_TRUE(act(R"({"action": "light", "light": "lamps", "intensity": 0.5, "color": [1, 0, 0]})"));
    for (const Light& light : lights(ns_per_s)) {
        EXPECT_EQ(light.intensity, 0.5f);
        EXPECT_EQ(light.color, glm::vec3(1, 0, 0));
    }
    const auto refused = act(R"({"action": "light", "light": "b", "intensity": 0})");
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, HasSubstr("do[0].light: 'b' is switched with its group 'lamps'; name that"));
    ASSERT_TRUE(act(R"({"action": "light", "light": "lamps", "flicker_hz": 20, "seconds": 2})"));
    bool was_off = false;
    for (TimeNs t = ns_per_s; t <= 4 * ns_per_s; t += 20 * ns_per_ms) {
        const auto now = lights(t);
        ASSERT_EQ(now[0].intensity, now[1].intensity) << t;
        was_off |= now[0].intensity == 0.0f;
    }
    EXPECT_TRUE(was_off);
    EXPECT_EQ(lights(4 * ns_per_s)[1].intensity, 0.5f) << "it ended as it was";
}

TEST(Act, ASunThatFlickersHasTheLightOfADayThatComes) {
    const auto scene = load_scene(written(by_day({{"azimuth_deg", 90}, {"elevation_deg", 60}})));
    ASSERT_TRUE(scene) << scene.error().message;
    auto world = World::create(*scene, 1).value();
    const auto act = [&](const char* text) {
        return world->act(
            event((std::string(R"({"name": "x", "when": {"at_s": 99}, "do": [)") + text + "]}").c_str()).actions);
    };
    const auto sun_at = [&](TimeNs t) {
        world->advance_to(t);
        return std::ranges::find(world->snapshot(t)->statics->lights, "sun", &Light::name)->intensity;
    };
    const float noon = sun_at(0);
    ASSERT_TRUE(act(R"({"action": "light", "light": "sun", "flicker_hz": 10, "seconds": 4})"));
    sun_at(ns_per_s);
    ASSERT_TRUE(act(R"({"action": "environment", "daylight": {"azimuth_deg": 270, "elevation_deg": 3}})"));
    float brightest = 0.0f;
    bool was_off = false;
    for (TimeNs t = ns_per_s; t < 4 * ns_per_s; t += 50 * ns_per_ms) {
        const float now = sun_at(t);
        was_off |= now == 0.0f;
        brightest = std::max(brightest, now);
    }
    EXPECT_TRUE(was_off);
    EXPECT_LT(brightest, 0.5f * noon);
    EXPECT_EQ(sun_at(5 * ns_per_s), brightest) << "it ended as that day is";
}

TEST(LightGroups, AreAlikeAndHaveNamesOfTheirOwn) {
    const auto told = [](const json& second) {
        json file = by_day({{"azimuth_deg", 90}, {"elevation_deg", 60}});
        file["lights"] = {{{"name", "a"}, {"type", "point"}, {"position", {0, 0, 3}}, {"group", "lamps"}}, second};
        const auto scene = load_scene(written(file));
        return scene ? std::string() : scene.error().message;
    };
    json lamp{{"name", "b"}, {"type", "point"}, {"position", {1, 0, 3}}, {"group", "lamps"}};
    EXPECT_EQ(told(lamp), "");
    lamp["intensity"] = 2;
    EXPECT_THAT(told(lamp), HasSubstr("lights[1]: has another color or intensity than 'a' of its group 'lamps'"));
    lamp.erase("intensity");
    lamp["candela"] = 1;
    EXPECT_THAT(told(lamp), HasSubstr("lights[1]: has another color or intensity")) << "of another unit";
    lamp.erase("candela");
    lamp["group"] = "a";
    EXPECT_THAT(told(lamp), HasSubstr("lights[1].group: 'a' is the name of a light"));
    EXPECT_THAT(told({{"name", "c"}, {"type", "directional"}, {"direction", {0, 0, -1}}, {"group", "lamps"}}),
                HasSubstr("group"))
        << "the sun is in none";
}

TEST(SceneBase, SaysOnlyWhatIsOtherwise) {
    json base = by_day({{"azimuth_deg", 90}, {"elevation_deg", 60}});
    base["lights"] = {{{"name", "lamp"}, {"type", "point"}, {"position", {0, 0, 3}}, {"intensity", 0}},
                      {{"name", "other"}, {"type", "point"}, {"position", {1, 0, 3}}}};
    written(base, "base.json");
    const auto scene = load_scene(written({{"camrig_scene", 1},
                                           {"name", "night"},
                                           {"base", "base.json"},
                                           {"environment", {{"daylight", nullptr}, {"exposure", 3}}},
                                           {"lights", {{{"name", "lamp"}, {"intensity", 30}}}},
                                           {"objects", {{{"name", "second"}, {"model", "box"}}}}},
                                          "night.json"));
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ((*scene)->name, "night");
    EXPECT_EQ((*scene)->environment.exposure, 3.0f);
    EXPECT_FALSE((*scene)->environment.daylight);
    ASSERT_EQ((*scene)->lights.size(), 2u) << "no sun";
    EXPECT_EQ((*scene)->lights[0].intensity, 30.0f);
    EXPECT_EQ((*scene)->lights[0].position.z, 3.0);
    EXPECT_EQ((*scene)->lights[1].intensity, 1.0f);
    ASSERT_EQ((*scene)->objects.size(), 3u);
    EXPECT_EQ((*scene)->objects[2].name, "second");
}

TEST(SceneBase, IsAShippedSceneOrAFileOfTheFolder) {
    const auto on = [](const char* base) {
        return load_scene(written({{"camrig_scene", 1}, {"name", "x"}, {"base", base}}, "on.json"));
    };
    const auto shipped = on("camrig:minimal");
    ASSERT_TRUE(shipped) << shipped.error().message;
    EXPECT_FALSE((*shipped)->models.empty());
    EXPECT_EQ((*shipped)->bases.at(0).filename(), "minimal.json");
    EXPECT_THAT(on("camrig:minmal").error().message, HasSubstr("on.json: base: minmal: no scene of this name"));
    EXPECT_THAT(on("../scene.json").error().message, HasSubstr("base: must be a .json file of the same folder"));
    EXPECT_THAT(on("missing.json").error().message, HasSubstr("missing.json: no such file"));
    EXPECT_THAT(on("on.json").error().message, HasSubstr("base: more than 8 files stand on each other"));
}

TEST(SceneBase, MustBeAnObjectOfItsFolderOrShipped) {
    const auto on = [](const std::string& base) {
        return load_scene(written({{"camrig_scene", 1}, {"name", "x"}, {"base", base}}, "on.json"));
    };
    for (const json& below : {json::array(), json(5), json("x"), json(nullptr)}) {
        written(below, "below.json");
        const auto scene = on("below.json");
        ASSERT_FALSE(scene) << below;
        EXPECT_THAT(scene.error().message, HasSubstr("below.json: expected an object, got"));
        EXPECT_FALSE(check_scene(written({{"camrig_scene", 1}, {"name", "x"}, {"base", "below.json"}})).scene);
    }
    const auto file = written(by_day({{"azimuth_deg", 90}, {"elevation_deg", 60}}), "below.json");
    for (const std::string& elsewhere : {file.string(), std::string("../below.json"), std::string("minimal.json")})
        EXPECT_THAT(on("camrig:" + elsewhere).error().message, HasSubstr("no scene of this name")) << elsewhere;
    EXPECT_TRUE(on("camrig:street-night")) << "which stands on another, by a name of its folder";
}

TEST(SceneBase, WhatIsTakenAwayNeedNotBeThere) {
    written({{"camrig_scene", 1}, {"name", "bare"}, {"models", json::object()}}, "bare.json");
    const auto scene = load_scene(written({{"camrig_scene", 1},
                                           {"name", "x"},
                                           {"base", "bare.json"},
                                           {"environment", {{"fog", nullptr}, {"exposure", 3}}}},
                                          "on.json"));
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ((*scene)->environment.exposure, 3.0f);
}

}  // namespace
}  // namespace camrig::world
