#include "core/render/software/baked_picture.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/camera/intrinsics.h"
#include "core/frame/frame_pool.h"
#include "core/frame/srgb.h"
#include "core/render/scene/light_sum.h"
#include "core/render/software/software_drawer.h"
#include "core/world/world.h"
#include "tests/unit/bake/scenes.h"

/// Pictures of quality beautiful in baked light.
namespace camrig::bake {
namespace {

/// A grey floor in a black yard: what it sees of the sky is known.
const std::vector<TestBox> yard{{"floor", {0, 0, -0.2}, {6, 6, 0.2}, 0.5}, {"wall", {2.5, 0, 0}, {0.4, 6, 3}, 0.0}};
const std::string sky = R"(, "environment": {"ambient": {"sky": [0.8, 0.6, 0.4], "ground": [0, 0, 0]}})";

world::SceneRef with_light(const world::SceneRef& scene) {
    auto made = std::make_shared<world::Scene>(*scene);
    use_baked_light(*made, std::make_shared<const world::BakedLight>(baked(scene, {.texels_per_m = 4.0, .rays = 256})));
    return made;
}

world::SnapshotRef begin_of(const world::SceneRef& scene) {
    auto world = world::World::create(scene, 1);
    EXPECT_TRUE(world.has_value());
    return (*world)->snapshot(0);
}

/// Draws by camrig's rasteriser; looks down along +x from over the floor's edge.
class Eye {
public:
    explicit Eye(world::Antialias antialias = world::Antialias::none) {
        auto spec = std::make_shared<world::CameraSpec>();
        spec->size = {64, 48};
        spec->intrinsics = camera::intrinsics_from_vfov(spec->size, 1.0).value();
        spec->antialias = antialias;
        view_.camera = CameraId{1};
        view_.name = std::make_shared<const std::string>("eye");
        view_.spec = spec;
        view_.quality = world::Quality::beautiful;
        view_.pose = camera::pose_look_at({-3.0, 0.0, 2.0}, {0.0, 0.0, 0.0}).value();
    }
    frame::FrameRef draw(const world::SnapshotRef& snapshot) {
        drawer_.begin_instant(snapshot);
        std::vector<frame::FrameRef> frames;
        const render::View* view = &view_;
        drawer_.draw(std::span(&view, 1), snapshot->world_ns, frames);
        EXPECT_EQ(frames.size(), 1u);
        return frames.at(0);
    }
    void look(const glm::dvec3& from, const glm::dvec3& at) { view_.pose = camera::pose_look_at(from, at).value(); }
    void set_quality(world::Quality quality) { view_.quality = quality; }
    void keep_nothing() { drawer_.forget(view_.camera); }

private:
    render::software::SoftwareDrawer drawer_{
        {.pool = std::make_shared<frame::FramePool>(), .static_layer_bytes = std::int64_t{1} << 26}};
    render::View view_;
};

std::vector<std::byte> bytes_of(const frame::FrameRef& frame) {
    return {frame->bytes().begin(), frame->bytes().end()};
}

/// Linear light of the pixel at the middle of the lowest row.
glm::dvec3 lowest(const frame::FrameRef& frame) {
    const ImageSize size = frame->info().size;
    const auto at = static_cast<std::size_t>((size.height - 1) * size.width + size.width / 2) * 4;
    glm::dvec3 light;
    for (int c = 0; c < 3; ++c)
        light[c] =
            frame::linear_of_srgb(std::to_integer<int>(frame->bytes()[at + static_cast<std::size_t>(c)]) / 255.0);
    return light;
}

/// The share of the diffuse and the mirrored light of a rough dielectric is not known here to better than this.
constexpr double surface_tolerance = 0.06;

TEST(BakedPicture, AFloorHasTheLightOfItsMap) {
    const auto scene = with_light(scene_of(yard, sky));
    Eye eye;
    const glm::dvec3 seen = lowest(eye.draw(begin_of(scene)));
    const double open = light_at(scene_of(yard, sky), *scene->baked_light, 0, "floor", {-1.95, 0, 0}, {0, 0, 1}).g;
    EXPECT_LT(open, 0.97) << "the wall hides something";
    for (int c = 0; c < 3; ++c) {
        const double of_sky = std::array{0.8, 0.6, 0.4}[static_cast<std::size_t>(c)];
        EXPECT_NEAR(seen[c], 0.5 * open * of_sky, surface_tolerance * of_sky) << c;
    }
}

TEST(BakedPicture, AnObjectThatWasHiddenHasItsMapAgain) {
    auto world = world::World::create(with_light(scene_of(yard, sky)), 1).value();
    Eye eye, other;
    ASSERT_TRUE(world->change_object({.name = "floor", .hidden = true}));
    eye.draw(world->snapshot(0));
    ASSERT_TRUE(world->change_object({.name = "floor", .hidden = false}));
    const auto shown = world->snapshot(0);
    EXPECT_EQ(bytes_of(eye.draw(shown)), bytes_of(other.draw(shown)));
}

TEST(BakedPicture, AnotherModelInAnObjectsPlaceHasNotItsLight) {
    const auto drawn = [scene = with_light(scene_of(yard, sky))](const std::string& name) {
        auto world = world::World::create(scene, 1).value();
        EXPECT_TRUE(world->remove_object("floor"));
        world::ObjectSpec wall = scene->objects[1];
        wall.name = name;
        wall.position = scene->objects[0].position;
        EXPECT_TRUE(world->spawn_object(wall));
        Eye eye;
        return bytes_of(eye.draw(world->snapshot(0)));
    };
    EXPECT_EQ(drawn("floor"), drawn("another"));
}

TEST(BakedPicture, OnlyBeautifulLooksAtIt) {
    const auto plain = scene_of(yard, sky);
    const auto scene = with_light(plain);
    for (const world::Quality quality : {world::Quality::fast, world::Quality::simple}) {
        Eye with, without;
        with.set_quality(quality);
        without.set_quality(quality);
        EXPECT_EQ(bytes_of(with.draw(begin_of(scene))), bytes_of(without.draw(begin_of(plain))));
    }
    Eye with, without;
    EXPECT_NE(bytes_of(with.draw(begin_of(scene))), bytes_of(without.draw(begin_of(plain))));
}

TEST(BakedPicture, AnotherSkyIsAnotherSumOfTheSameMap) {
    const auto scene = with_light(scene_of(yard, sky));
    auto darker = std::make_shared<world::Scene>(*scene);
    darker->environment.ambient_sky *= 0.5f;
    Eye eye;
    const glm::dvec3 before = lowest(eye.draw(begin_of(scene))), after = lowest(eye.draw(begin_of(darker)));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(after[c], 0.5 * before[c], 0.004) << c;
}

TEST(BakedPicture, LampsThatFlickerAreAtTheirPeakInTheMap) {
    const auto scene = with_light(scene_of(
        yard, sky + R"(, "lights": [{"name": "lamp", "type": "point", "position": [0, 0, 2], "flicker_depth": 0.5}])"));
    const auto statics = begin_of(scene)->statics;
    const std::size_t lamp = layer_of(*scene->baked_light, world::LightSource::lamp);
    const std::size_t of_sky = layer_of(*scene->baked_light, world::LightSource::sky);
    render::software::BakedPictures pictures;
    for (int turn = 0; turn < 2; ++turn) {
        const auto in_mean = pictures.of(*statics), at_peak = pictures.of(*statics, 100.0);
        EXPECT_NEAR(at_peak->weights[lamp].r / in_mean->weights[lamp].r, 1.5, 1e-6);
        EXPECT_EQ(at_peak->weights[of_sky], in_mean->weights[of_sky]);
        EXPECT_EQ(pictures.of(*statics), in_mean) << "both are kept";
        EXPECT_EQ(pictures.of(*statics, 120.0)->weights, in_mean->weights) << "another frequency";
    }
}

TEST(BakedPicture, ADarkerGroundMakesNothingBrighter) {
    std::vector<TestBox> roofed = yard;
    roofed.push_back({"roof", {0, 0, 2}, {6, 6, 0.2}, 0.5});
    double before = 0.0;
    for (const char* const below : {"0", "0.001", "0.1", "0.3", "0.6"}) {
        const auto scene = with_light(
            scene_of(roofed, std::string(R"(, "environment": {"ambient": {"sky": [0.8, 0.8, 0.8], "ground": [)") +
                                 below + "," + below + "," + below + "]}}"));
        Eye eye;
        eye.look({-2.5, 0, 1}, {0, 0, 2});
        double sum = 0.0;
        const auto frame = eye.draw(begin_of(scene));
        for (const std::byte one : frame->bytes()) sum += std::to_integer<int>(one);
        EXPECT_GE(sum, before) << below;
        before = sum;
    }
}

TEST(BakedPicture, AnObjectThatWasMovedTakesTheLightOfAProbe) {
    const auto scene = with_light(scene_of(yard, sky));
    const auto stands = begin_of(scene);
    auto statics = std::make_shared<world::StaticSet>(*stands->statics);
    statics->objects[0].position.z -= 0.01;
    auto moved = std::make_shared<world::Snapshot>(*stands);
    moved->statics = statics;
    Eye eye;
    const glm::dvec3 seen = lowest(eye.draw(moved));
    const auto probe = render::scene::probe_at(
        scene->baked_light->grid,
        render::scene::sum_probes(*scene->baked_light, render::scene::layer_weights(*statics)), {0, 0, -0.11});
    ASSERT_TRUE(probe.has_value());
    const glm::vec3 light = probe->mean + probe->along[2];
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], 0.5 * light[c], surface_tolerance) << c;
}

TEST(BakedPicture, StandingCamerasShowTheBytesOfAWholePicture) {
    auto scene = std::make_shared<world::Scene>(*with_light(scene_of(
        yard, sky + R"(, "lights": [{"name": "sun", "type": "directional", "direction": [0.4, 0.2, -0.8]}])")));
    const auto first = begin_of(scene);
    for (const world::Antialias antialias : {world::Antialias::none, world::Antialias::coverage}) {
        Eye standing(antialias), anew(antialias);
        for (int step = 0; step < 4; ++step) {
            // The wall as a thing that moves, and casts its shadow.
            auto now = std::make_shared<world::Snapshot>(*first);
            auto statics = std::make_shared<world::StaticSet>(*first->statics);
            now->movers.push_back(statics->objects[1]);
            now->movers[0].position.x = 0.3 * step;
            now->movers[0].scale = 0.3;
            static std::map<world::Antialias, std::shared_ptr<const world::StaticSet>> kept;
            auto& one = kept[antialias];
            if (one == nullptr) {
                statics->objects.pop_back();
                one = statics;
            }
            now->statics = one;
            now->world_ns = step * ns_per_s;
            anew.keep_nothing();
            EXPECT_EQ(bytes_of(standing.draw(now)), bytes_of(anew.draw(now))) << step;
        }
    }
}

TEST(BakedPicture, ProbesInWallsAreNotAsked) {
    world::ProbeGrid grid{.first = {0, 0, 0}, .spacing_m = 1.0, .count = {2, 1, 1}, .is_open = {0, 1}};
    std::vector<world::LightProbe> probes(2);
    probes[0].mean = glm::vec3(9.0f);
    probes[1].mean = glm::vec3(2.0f);
    probes[1].products[2] = glm::vec3(0.5f);
    EXPECT_NEAR(render::scene::probe_at(grid, probes, {0.2, 0, 0})->mean.g, 2.0, 1e-5);
    EXPECT_NEAR(render::scene::probe_at(grid, probes, {0.2, 0, 0})->products[2].g, 0.5, 1e-5);
    grid.is_open = {1, 1};
    EXPECT_NEAR(render::scene::probe_at(grid, probes, {0.5, 0, 0})->mean.g, 5.5, 0.02);
    EXPECT_NEAR(render::scene::probe_at(grid, probes, {0.5, 0, 0})->products[2].g, 0.25, 0.01);
    EXPECT_NEAR(render::scene::probe_at(grid, probes, {7, 3, -3})->mean.g, 2.0, 0.05);
    grid.is_open = {0, 0};
    EXPECT_FALSE(render::scene::probe_at(grid, probes, {0.5, 0, 0}).has_value());
}

}  // namespace
}  // namespace camrig::bake
