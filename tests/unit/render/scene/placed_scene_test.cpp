#include "core/render/scene/placed_scene.h"

#include <atomic>
#include <thread>

#include <gmock/gmock.h>

#include "core/render/scene/scene_view.h"
#include "core/render/shown_picture.h"
#include "tests/render/support/test_models.h"

namespace camrig::render::scene {
namespace {

using testing::ElementsAre;

TEST(ModelCache, AModelIsMadeOnceHoweverManyThreadsAskForIt) {
    const world::ModelRef model = model_of(box(glm::vec3(1.0f)), colored(glm::vec3(0.5f)));
    ModelCache<int> cache;
    std::atomic<int> makes = 0, sum = 0;
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < 4; ++i)
            threads.emplace_back([&] { sum += cache.of(model, [&](const world::ModelRef&) { return ++makes, 7; }); });
    }
    EXPECT_EQ(makes, 1);
    EXPECT_EQ(sum, 28);
}

TEST(ModelCache, WhatWasMadeOfAModelGoesWithItAndNoSooner) {
    world::ModelRef model = model_of(box(glm::vec3(1.0f)), colored(glm::vec3(0.5f)));
    const auto made = std::make_shared<int>(1);
    ModelCache<std::shared_ptr<int>> cache;
    cache.of(model, [&](const world::ModelRef&) { return made; });
    cache.evict_unused();
    EXPECT_EQ(made.use_count(), 2);
    model.reset();
    cache.evict_unused();
    EXPECT_EQ(made.use_count(), 1);
}

TEST(ModelCache, WhatCouldNotBeMadeIsTriedAgain) {
    const world::ModelRef model = model_of(box(glm::vec3(1.0f)), colored(glm::vec3(0.5f)));
    ModelCache<int> cache;
    EXPECT_THROW(cache.of(model, [](const world::ModelRef&) -> int { throw std::bad_alloc(); }), std::bad_alloc);
    EXPECT_EQ(cache.of(model, [](const world::ModelRef&) { return 3; }), 3);
}

world::Material glass() {
    world::Material material = colored(glm::vec3(0.5f));
    material.alpha_mode = world::AlphaMode::blend;
    return material;
}

/// A wall that stands, and three movers before it of which one is glass; the last is far beside the picture.
TestWorld world() {
    TestWorld world;
    world.lights = {light_of(world::LightType::directional, 0.8f, {}, glm::dvec3(1.0, 0.0, 0.0))};
    const world::ModelRef brick = model_of(box(glm::vec3(0.2f)), colored(glm::vec3(0.5f)));
    world.objects = {instance_of(brick, {6, 0, 0}, 1)};
    world.movers = {instance_of(brick, {5, 0.5, 0}, 2),
                    instance_of(model_of(box(glm::vec3(0.2f)), glass()), {4, -0.5, 0}, 3),
                    instance_of(brick, {5, 90, 0}, 4)};
    return world;
}

PlacedScene placed(const world::SnapshotRef& snapshot) {
    PlacedScene scene(std::make_shared<PreparedModels>());
    scene.place(snapshot);
    return scene;
}

/// From the origin along x.
SceneView seen_of(const PlacedScene& scene) {
    return make_scene_view(scene, make_view_transform({}, {64, 48}, {64.0, 64.0, 31.5, 23.5}, 0.05, 0.0), 0.0,
                           world::Quality::simple, 0.0);
}

std::vector<std::uint32_t> ids_of(const std::vector<SeenSurface>& seen) {
    std::vector<std::uint32_t> ids;
    for (const SeenSurface& surface : seen) ids.push_back(static_cast<std::uint32_t>(surface.placed->object->id));
    return ids;
}

TEST(PlacedScene, WhatStandsStillStaysPlacedUntilItsSetIsAnother) {
    const world::SnapshotRef first = world().snapshot();
    PlacedScene scene = placed(first);
    const PlacedSurface* const wall = scene.statics().all().data();
    auto later = std::make_shared<world::Snapshot>(*first);
    later->movers[0].position.y = 1.0;
    scene.place(later);
    EXPECT_EQ(scene.statics().all().data(), wall);
    EXPECT_EQ(scene.statics_number(), 1u);
    EXPECT_EQ(scene.movers().all()[0].world_from_local[3].y, 1.0);
}

TEST(PlacedScene, ALightThatFlickersIsAnotherSetOfTheSameObjects) {
    const world::SnapshotRef first = world().snapshot();
    PlacedScene scene = placed(first);
    auto statics = std::make_shared<world::StaticSet>(*first->statics);
    statics->lights[0].intensity *= 2.0f;
    auto brighter = std::make_shared<world::Snapshot>(*first);
    brighter->statics = statics;
    scene.place(brighter);
    EXPECT_EQ(scene.statics_number(), 2u);
    EXPECT_EQ(scene.objects_number(), 1u);
    statics = std::make_shared<world::StaticSet>(*statics);
    statics->objects[0].position.y = 1.0;
    auto moved = std::make_shared<world::Snapshot>(*brighter);
    moved->statics = statics;
    scene.place(moved);
    EXPECT_EQ(scene.objects_number(), 2u);
}

TEST(SceneView, ListsWhatMayBeSeenOpaqueAndBlendedApart) {
    const PlacedScene scene = placed(world().snapshot());
    std::vector<SeenSurface> opaque, blended;
    seen_of(scene).see_all(true, &opaque, &blended);
    EXPECT_THAT(ids_of(opaque), ElementsAre(1));
    EXPECT_TRUE(blended.empty());
    seen_of(scene).see_all(false, &opaque, &blended);
    EXPECT_THAT(ids_of(opaque), ElementsAre(1, 2)) << "4 is beside the picture";
    EXPECT_THAT(ids_of(blended), ElementsAre(3));
    blended.clear();
    seen_of(scene).see_all(false, nullptr, &blended);
    EXPECT_THAT(ids_of(blended), ElementsAre(3));
}

TEST(SceneView, WhatMovesLiesWithinItsRectangles) {
    const PlacedScene scene = placed(world().snapshot());
    SeenMovers movers;
    movers.see(seen_of(scene));
    EXPECT_THAT(ids_of(movers.opaque), ElementsAre(2));
    EXPECT_THAT(ids_of(movers.blended), ElementsAre(3));
    ASSERT_EQ(movers.rects.size(), 2u);
    // World +y is to the left.
    EXPECT_LT(movers.rects[0].x1, 32);
    EXPECT_GT(movers.rects[1].x0, 31);
    EXPECT_TRUE(seen_of(scene).touches(movers.opaque[0], movers.rects));
    EXPECT_FALSE(seen_of(scene).touches(movers.opaque[0], std::span(movers.rects).subspan(1)));
}

TEST(SceneView, BlendedSurfacesComeFromFarToNearAndEqualOnesAsInTheScene) {
    std::vector<SeenSurface> draws(4);
    const PlacedSurface placed[4]{};
    for (std::size_t i = 0; i < 4; ++i) draws[i].placed = placed + i;
    draws[0].distance_m = 1.0;
    draws[1].distance_m = draws[2].distance_m = 5.0;
    draws[3].distance_m = 7.0;
    sort_far_to_near(draws);
    std::vector<std::ptrdiff_t> order;
    for (const SeenSurface& draw : draws) order.push_back(draw.placed - placed);
    EXPECT_THAT(order, ElementsAre(3, 1, 2, 0));
}

frame::Damage since(std::int64_t layer, int first, int end) {
    frame::Damage made = frame::Damage::since(layer);
    made.add(first, end);
    return made;
}

TEST(ShownPicture, DiffersFromTheLastOneOfItsLayerWhereEitherHasSomethingElse) {
    ShownPicture picture;
    EXPECT_EQ(picture.next(10, since(4, 0, 16)), frame::Damage{}) << "nothing was before";
    frame::Damage both = since(10, 0, 16);
    both.add(32, 48);
    EXPECT_EQ(picture.next(11, since(4, 32, 48)), both);
    EXPECT_EQ(picture.next(12, since(5, 0, 0)), frame::Damage{}) << "another layer";
    EXPECT_EQ(picture.next(13, {}), frame::Damage{}) << "no layer";
    EXPECT_EQ(picture.next(14, {}), frame::Damage{}) << "nothing is known of two pictures without a layer";
}

TEST(ShownPicture, ThatIsDrawnAnewUnderItsNumberIsNoBase) {
    ShownPicture picture;
    picture.next(10, since(4, 0, 16));
    picture.next(11, since(4, 0, 16));
    // A command turned the camera: a reader may have either picture 11.
    EXPECT_EQ(picture.next(11, {}), frame::Damage{});
    picture.next(11, since(5, 0, 16));
    EXPECT_EQ(picture.next(12, since(5, 0, 16)), frame::Damage{});
    EXPECT_EQ(picture.next(13, since(5, 0, 16)).base(), 12);
    EXPECT_EQ(picture.next(13, since(5, 0, 16)).base(), 13) << "the same picture, in another form";
    EXPECT_EQ(picture.next(14, since(5, 0, 16)).base(), 13);
}

}  // namespace
}  // namespace camrig::render::scene
