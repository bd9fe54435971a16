#include <gtest/gtest.h>

#include "core/world/world.h"
#include "tests/render/support/two_rasterisers.h"
#include "tests/unit/bake/scenes.h"

// A room whose light is baked, at quality beautiful: by OpenGL as by camrig's rasteriser.
namespace camrig::render {
namespace {

world::SceneRef lit_room() {
    std::vector<bake::TestBox> boxes = bake::room({6, 5, 3}, 0.6);
    boxes.push_back({"table", {0.8, 0.9, 0}, {0.9, 0.9, 0.8}, 0.4});
    boxes.push_back({"crate", {0.4, -1.0, 0}, {0.7, 0.7, 0.7}, 0.5});
    const auto scene = bake::scene_of(boxes, R"(,
        "environment": {"ambient": {"sky": [0.2, 0.2, 0.25], "ground": [0.1, 0.1, 0.1]}},
        "lights": [
            {"name": "lamp", "type": "point", "color": [1, 0.9, 0.7], "intensity": 2.5, "position": [0.2, 0.2, 2.6]},
            {"name": "spot", "type": "spot", "color": [0.5, 0.7, 1], "intensity": 6, "position": [2.5, -1.5, 2.8],
             "direction": [-0.5, 0.3, -0.8], "inner_cone_deg": 20, "outer_cone_deg": 35}],
        "events": [{"name": "late", "when": {"at_s": 1}, "do": [{"action": "light", "light": "lamp", "intensity": 0.3}]}])");
    auto made = std::make_shared<world::Scene>(*scene);
    use_baked_light(*made, std::make_shared<const world::BakedLight>(
                               bake::baked(scene, {.texels_per_m = 4.0, .rays = 64, .probe_spacing_m = 0.7})));
    return made;
}

class BakedRoom : public testing::Test {
protected:
    BakedRoom() {
        static const world::SceneRef scene = lit_room();
        world_ = std::move(*world::World::create(scene, 1));
        TestCamera camera{.eye = {-2.8, 0.1, 1.6}, .size = {160, 120}, .focal_px = 90.0};
        camera.quality = world::Quality::beautiful;
        view_ = camera.view(81);
        crate_ = {static_cast<std::uint32_t>(at(0)->statics->objects.back().info->id)};
    }
    world::SnapshotRef at(TimeNs world_ns) {
        world_->advance_to(world_ns);
        return world_->snapshot(world_ns);
    }

    std::unique_ptr<world::World> world_;
    View view_;
    std::vector<std::uint32_t> crate_;
};

/// The snapshot with its crate elsewhere: as what stands there, or as what moves.
world::SnapshotRef with_crate(const world::SnapshotRef& from, bool is_mover) {
    auto statics = std::make_shared<world::StaticSet>(*from->statics);
    auto made = std::make_shared<world::Snapshot>(*from);
    world::Instance crate = statics->objects.back();
    crate.position = {0.1, -0.9, 0.25};
    crate.orientation = glm::angleAxis(0.6, glm::dvec3(0, 0, 1));
    statics->objects.pop_back();
    (is_mover ? made->movers : statics->objects).push_back(crate);
    made->statics = statics;
    return made;
}

TEST_F(BakedRoom, StandsInTheSameLight) {
    expect_alike(at(0), view_, "room");
}

TEST_F(BakedRoom, WhatWasMovedTakesTheLightOfAProbe) {
    const auto moved = with_crate(at(0), false);
    expect_alike(moved, view_, "moved");
    expect_alike(moved, view_, "the moved crate", crate_);
}

TEST_F(BakedRoom, WhatMovesTakesTheLightOfAProbe) {
    const auto moving = with_crate(at(0), true);
    for (int i = 0; i < 3; ++i) expect_alike(moving, view_, "moving, picture " + std::to_string(i));
    expect_alike(moving, view_, "the moving crate", crate_);
}

TEST_F(BakedRoom, ALampThatAnEventDimsIsSeenByACameraThatStands) {
    const auto before = at(0);
    for (int i = 0; i < 3; ++i) drawn_by("llvmpipe", before, view_);  // what stands still is kept by now
    const auto bright = drawn_by("llvmpipe", before, view_);
    const auto after = at(2 * ns_per_s);
    const auto dim = drawn_by("llvmpipe", after, view_);
    EXPECT_LT(alike(bright, dim).share(), 0.1) << "nothing has become darker";
    expect_alike(after, view_, "dimmed");
    renderer_of("llvmpipe").forget(view_.camera);
    EXPECT_TRUE(std::ranges::equal(dim->bytes(), drawn_by("llvmpipe", after, view_)->bytes()));
}

TEST_F(BakedRoom, LampsAreNotAddedToTheirBakedLight) {
    // As if they were out, but for the map: its layers have their light in any case.
    const auto lit = at(0);
    auto statics = std::make_shared<world::StaticSet>(*lit->statics);
    statics->baked_light = nullptr;
    auto unbaked = std::make_shared<world::Snapshot>(*lit);
    unbaked->statics = statics;
    EXPECT_LT(alike(drawn_by("llvmpipe", lit, view_), drawn_by("llvmpipe", unbaked, view_)).share(), 0.5);
    expect_alike(unbaked, view_, "without baked light");
    expect_alike(lit, view_, "and with it again");
}

}  // namespace
}  // namespace camrig::render
