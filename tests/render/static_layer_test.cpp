#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/render/gl/static_layers.h"
#include "core/render/software/software_drawer.h"
#include "tests/render/support/claims.h"
#include "tests/render/support/test_body.h"
#include "tests/render/support/test_rig.h"

// A kept picture of what does not move must never show: with it and without it, the same bytes.
namespace camrig::render {
namespace {

constexpr std::uint32_t standing = 1;
constexpr std::uint32_t fresh = 2;  ///< seen for the first time with every view: drawn in full

/// A room of boxes on a floor, one of them glass, somebody who stands there, and something and somebody that move among
/// them and through them. At quality `beautiful` the sun and a lamp cast shadows of all of it, and bodies darken what
/// is beside them.
TestWorld room() {
    TestWorld world;
    world.lights = {
        light_of(world::LightType::directional, 0.8f, {}, glm::normalize(glm::dvec3(1.0, 0.4, -0.7))),
        light_of(world::LightType::spot, 9.0f, {3.0, -1.5, 2.5}, glm::normalize(glm::dvec3(0.6, 0.4, -0.8)))};
    std::uint32_t id = 1;
    for (int i = -2; i <= 2; ++i) {
        const world::Material paint = colored({0.2f + 0.15f * static_cast<float>(i), 0.5f, 0.4f});
        world.objects.push_back(instance_of(model_of(box({0.4f, 0.4f, 0.7f}), paint), {5.0, 1.1 * i, -0.3}, id++));
    }
    world.objects.push_back(
        instance_of(model_of(rectangle({6, 0, -1}, {6, 0, 0}, {0, 6, 0}), colored(glm::vec3(0.7f))), {}, id++));
    world::Material glass = colored({0.3f, 0.5f, 0.9f});
    glass.alpha_mode = world::AlphaMode::blend;
    glass.base_color.a = 0.4f;
    world.objects.push_back(instance_of(model_of(box({0.1f, 1.2f, 0.8f}), glass), {4.0, 0.6, 0.0}, id++));
    world.movers.push_back(instance_of(model_of(box({0.3f, 0.3f, 0.5f}), colored({0.9f, 0.2f, 0.1f})), {}, id++));
    world.movers.push_back(instance_of(model_of(box({0.2f, 0.2f, 0.9f}), glass), {}, id++));
    return world;
}

/// The same with somebody who stands and somebody who walks, and a lamp that shines to all sides.
TestWorld room_with_people() {
    TestWorld world = room();
    world.lights.push_back(light_of(world::LightType::point, 2.0f, {3.0, 0.5, 1.5}));
    world.objects.push_back(instance_of(leg_and_cube(), {4.4, -0.9, -1.0}, 101));
    world.movers.push_back(instance_of(leg_and_cube(), {}, 102));
    return world;
}

/// Snapshots of one world: the statics stay the same, as in the engine.
class Moments {
public:
    explicit Moments(const TestWorld& world) : first_(world.snapshot()) {}
    world::SnapshotRef at(double where) const {
        auto snapshot = std::make_shared<world::Snapshot>(*first_);
        snapshot->movers[0].position = {4.6, -2.0 + where, 0.1};
        snapshot->movers[1].position = {5.4, 1.5 - where, 0.0};
        if (snapshot->movers.size() > 2) snapshot->movers[2].position = {4.3, 1.3 - 0.8 * where, -1.0};
        return snapshot;
    }

private:
    world::SnapshotRef first_;
};

/// The moment, with other lights on the same objects.
world::SnapshotRef flickered(const world::Snapshot& moment, const std::vector<world::Light>& lights) {
    auto statics = std::make_shared<world::StaticSet>(*moment.statics);
    statics->lights = lights;
    auto made = std::make_shared<world::Snapshot>(moment);
    made->statics = std::move(statics);
    return made;
}

View numbered(View view, std::uint32_t number) {
    view.camera = CameraId{number};
    return view;
}

std::vector<std::byte> bytes_of(const std::vector<frame::FrameRef>& frames) {
    std::vector<std::byte> all;
    for (const frame::FrameRef& frame : frames) all.insert(all.end(), frame->bytes().begin(), frame->bytes().end());
    return all;
}

View all_kinds(View view, bool with_color = true) {
    for (const frame::FrameKind kind : {frame::FrameKind::depth, frame::FrameKind::instance, frame::FrameKind::normal})
        view.kinds[static_cast<int>(kind)] = true;
    view.kinds[static_cast<int>(frame::FrameKind::color)] = with_color;
    return view;
}

/// Draws the view now with its layer, and as a camera that nobody saw before.
void expect_same(const world::SnapshotRef& moment, const View& view, const std::string& what) {
    const auto layered = bytes_of(draw_views(moment, {&view, 1}));
    cpu_renderer().forget(CameraId{fresh});
    const View again = numbered(view, fresh);
    EXPECT_TRUE(layered == bytes_of(draw_views(moment, {&again, 1}))) << what;
}

class StaticLayer : public testing::Test {
protected:
    void SetUp() override { cpu_renderer().forget(CameraId{standing}); }
    static std::uint64_t reused() { return cpu_renderer().counters().layers_reused; }

    const Moments moments_{room()};
};

TEST_F(StaticLayer, NeverShowsInAnyQualityAntialiasingOrLens) {
    const camera::Lens fisheye = make_lens(camera::LensModel::equidistant, std::vector{0.02, -0.01, 0.0, 0.0}).value();
    const camera::Lens barrel =
        make_lens(camera::LensModel::plumb_bob, std::vector{-0.25, 0.05, 0.001, -0.001, 0.0}).value();
    for (const world::Quality quality : {world::Quality::fast, world::Quality::simple, world::Quality::beautiful}) {
        for (const world::Antialias antialias :
             {world::Antialias::none, world::Antialias::coverage, world::Antialias::msaa4, world::Antialias::ssaa2}) {
            for (const camera::Lens& lens : {camera::Lens{}, barrel, fisheye}) {
                const TestCamera camera{.size = {97, 61},
                                        .focal_px = lens == fisheye ? 25.0 : 60.0,
                                        .lens = lens,
                                        .antialias = antialias,
                                        .quality = quality};
                const View view = all_kinds(camera.view(standing));
                const std::uint64_t before = reused();
                for (int n = 0; n < 4; ++n) {
                    expect_same(moments_.at(0.9 * n), view,
                                std::string(to_string(quality)) + " " + std::string(to_string(antialias)) + " " +
                                    std::string(to_string(lens.model)) + ", picture " + std::to_string(n));
                }
                // Of the third and fourth picture; where colour is drawn apart from the rest, both have a layer.
                const bool is_together = software::SoftwareDrawer::may_draw(view) &&
                                         software::SoftwareDrawer::may_draw(view, frame::FrameKind::depth);
                EXPECT_EQ(reused() - before, is_together ? 2u : 4u);
            }
        }
    }
}

TEST_F(StaticLayer, NeverShowsInWhatPeopleKeepFromLampsAndFromAllAround) {
    const camera::Lens barrel =
        make_lens(camera::LensModel::plumb_bob, std::vector{-0.25, 0.05, 0.001, -0.001, 0.0}).value();
    const Moments moments(room_with_people());
    for (const world::Quality quality : {world::Quality::simple, world::Quality::beautiful}) {
        for (const world::Antialias antialias :
             {world::Antialias::none, world::Antialias::coverage, world::Antialias::msaa4}) {
            for (const camera::Lens& lens : {camera::Lens{}, barrel}) {
                const TestCamera camera{
                    .size = {97, 61}, .focal_px = 60.0, .lens = lens, .antialias = antialias, .quality = quality};
                const View view = all_kinds(camera.view(standing));
                for (int n = 0; n < 4; ++n)
                    expect_same(moments.at(0.9 * n), view,
                                std::string(to_string(quality)) + " " + std::string(to_string(antialias)) +
                                    ", picture " + std::to_string(n));
            }
        }
    }
}

TEST_F(StaticLayer, TruthAloneAndColourLaterHaveTheirOwn) {
    const View view = TestCamera{.size = {80, 60}}.view(standing);
    const View truth = all_kinds(view, false);
    for (int n = 0; n < 3; ++n) expect_same(moments_.at(n), truth, "truth");
    for (int n = 0; n < 3; ++n) expect_same(moments_.at(n), view, "colour");
    for (int n = 0; n < 3; ++n) expect_same(moments_.at(n), all_kinds(view), "both");
}

TEST_F(StaticLayer, NothingOfAMoverStaysWhereItWas) {
    // Small movers far apart, so that only rectangles around them are drawn; one leaves the picture, one comes close.
    TestWorld world = room();
    const View view = TestCamera{.size = {320, 200}, .focal_px = 150.0}.view(standing);
    const world::SnapshotRef first = world.snapshot();
    for (int n = 0; n < 8; ++n) {
        auto snapshot = std::make_shared<world::Snapshot>(*first);
        for (std::size_t i = 0; i < snapshot->movers.size(); ++i) snapshot->movers[i].scale = 0.3;
        snapshot->movers[0].position = {4.2, -1.0 + n, 0.2};
        snapshot->movers[1].position = {8.0 - 1.15 * n, 1.0 - 0.3 * n, 0.0};
        expect_same(snapshot, view, "picture " + std::to_string(n));
    }
    EXPECT_GE(reused(), 6u);
}

TEST_F(StaticLayer, ViewsOfOneInstantShowWhatEachShowsAlone) {
    // All kept pictures are put back before the first view is drawn; the sources of some are shared.
    const camera::Lens fisheye = make_lens(camera::LensModel::equidistant, std::vector{0.02, -0.01, 0.0, 0.0}).value();
    std::vector<View> views;
    std::uint32_t number = 11;
    for (const world::Quality quality : {world::Quality::simple, world::Quality::beautiful}) {
        for (const world::Antialias antialias :
             {world::Antialias::none, world::Antialias::coverage, world::Antialias::msaa4, world::Antialias::ssaa2}) {
            for (const camera::Lens& lens : {camera::Lens{}, fisheye}) {
                const TestCamera camera{.size = {160, 100},
                                        .focal_px = lens == fisheye ? 40.0 : 75.0,
                                        .lens = lens,
                                        .antialias = antialias,
                                        .quality = quality};
                cpu_renderer().forget(CameraId{number});
                views.push_back(numbered(camera.view(standing), number++));
            }
        }
    }
    const std::uint64_t before = cpu_renderer().counters().views_in_parts;
    for (int n = 0; n < 4; ++n) {
        auto moment = std::make_shared<world::Snapshot>(*moments_.at(0.4 * n));
        for (auto& mover : moment->movers) mover.scale = 0.3;
        const std::vector<frame::FrameRef> together = draw_views(moment, views);
        ASSERT_EQ(together.size(), views.size());
        for (std::size_t i = 0; i < views.size(); ++i) {
            cpu_renderer().forget(CameraId{fresh});
            const View alone = numbered(views[i], fresh);
            EXPECT_TRUE(bytes_of({together[i]}) == bytes_of(draw_views(moment, {&alone, 1})))
                << "view " << i << ", picture " << n;
        }
    }
    EXPECT_GT(cpu_renderer().counters().views_in_parts, before);
    for (const View& view : views) cpu_renderer().forget(view.camera);
}

TEST_F(StaticLayer, FramesSayWhichRowsMayHaveChanged) {
    const camera::Lens barrel =
        make_lens(camera::LensModel::plumb_bob, std::vector{-0.25, 0.05, 0.001, -0.001, 0.0}).value();
    const world::SnapshotRef first = room().snapshot();
    for (const world::Quality quality : {world::Quality::simple, world::Quality::beautiful}) {
        for (const world::Antialias antialias :
             {world::Antialias::none, world::Antialias::ssaa2, world::Antialias::msaa4}) {
            for (const camera::Lens& lens : {camera::Lens{}, barrel}) {
                cpu_renderer().forget(CameraId{standing});
                View view =
                    TestCamera{
                        .size = {320, 200}, .focal_px = 150.0, .lens = lens, .antialias = antialias, .quality = quality}
                        .view(standing);
                Claims claims;
                for (int n = 0; n < 12; ++n) {
                    view.sequence = 5 + n;
                    auto snapshot = std::make_shared<world::Snapshot>(*first);
                    for (auto& mover : snapshot->movers) mover.scale = 0.2;
                    snapshot->movers[0].position = {4.2, -1.0 + 0.1 * n, -0.5 + 0.1 * (n / 3)};
                    snapshot->movers[1].position = {5.0, 1.0, n % 4 == 3 ? 50.0 : 0.4};
                    const std::string what = std::string(to_string(quality)) + " " + std::string(to_string(antialias)) +
                                             " " + std::string(to_string(lens.model)) + ", picture " +
                                             std::to_string(n);
                    const View truth = all_kinds(view, false);
                    if (n % 3 == 1) draw_views(snapshot, {&truth, 1});
                    claims.check(draw_views(snapshot, {&view, 1}).at(0), what);
                    // Drawn again, as on demand.
                    if (n % 4 == 2) claims.check(draw_views(snapshot, {&view, 1}).at(0), what + " again");
                }
                // Where the scene is drawn in parts: by Mesa not through lenses, nor with several samples a pixel drawn
                // at once.
                const bool is_ours = cpu_renderer().is_on_cpu() && software::SoftwareDrawer::may_draw(view);
                const bool is_known = is_ours || (lens == camera::Lens{} && antialias != world::Antialias::msaa4);
                // Our rasteriser gives the first of them twice, as it is, where it has drawn it beside the truth.
                EXPECT_EQ(claims.named, !is_known ? 0
                                        : is_ours ? 11
                                                  : 12)
                    << "of 15, of which the first three make the layer";
                // Where shadows may lie is not bounded through a lens.
                const bool is_bounded = lens == camera::Lens{} || quality != world::Quality::beautiful;
                EXPECT_EQ(claims.unchanged_share() > 0.3, is_known && is_bounded);
            }
        }
    }
}

TEST_F(StaticLayer, NoShadowOfAMoverStaysWhereItWas) {
    // Small movers, so that only rectangles around them and their shadows are drawn; some stand beside the picture and
    // above it, and only their shadows are seen.
    const TestWorld world = room();
    const world::SnapshotRef first = world.snapshot();
    const camera::Lens pinhole{},
        barrel = make_lens(camera::LensModel::plumb_bob, std::vector{-0.25, 0.05, 0.001, -0.001, 0.0}).value(),
        fisheye = make_lens(camera::LensModel::equidistant, std::vector{0.02, -0.01, 0.0, 0.0}).value();
    for (const auto& [antialias, lens] : {std::pair(world::Antialias::none, pinhole),
                                          {world::Antialias::automatic, pinhole},
                                          {world::Antialias::ssaa2, pinhole},
                                          {world::Antialias::none, barrel},
                                          {world::Antialias::automatic, barrel},
                                          {world::Antialias::automatic, fisheye}}) {
        cpu_renderer().forget(CameraId{standing});
        const View view = TestCamera{.size = {320, 200},
                                     .focal_px = lens == fisheye ? 80.0 : 150.0,
                                     .lens = lens,
                                     .antialias = antialias,
                                     .quality = world::Quality::beautiful}
                              .view(standing);
        for (int n = 0; n < 8; ++n) {
            auto snapshot = std::make_shared<world::Snapshot>(*first);
            for (std::size_t i = 0; i < snapshot->movers.size(); ++i) snapshot->movers[i].scale = 0.3;
            snapshot->movers[0].position = {3.0 + 0.3 * n, -3.0 + n, -0.4};
            snapshot->movers[1].position = {4.2 - 0.5 * n, 1.0 - 0.3 * n, 2.6};
            expect_same(snapshot, view,
                        std::string(to_string(antialias)) + " " + std::string(to_string(lens.model)) + ", picture " +
                            std::to_string(n));
        }
    }
}

TEST_F(StaticLayer, IsDrawnAnewWhenAnythingItShowsChanges) {
    View view = TestCamera{.size = {80, 60}}.view(standing);
    const auto settle = [&] {
        for (int n = 0; n < 3; ++n) draw_views(moments_.at(n), {&view, 1});
    };
    settle();
    view.pose.position.y += 0.3;
    expect_same(moments_.at(1.0), view, "pose");
    settle();
    view.quality = world::Quality::fast;
    expect_same(moments_.at(1.0), view, "quality");
    settle();
    view = numbered(TestCamera{.size = {80, 60}, .focal_px = 50.0}.view(standing), standing);
    expect_same(moments_.at(1.0), view, "field of view");
    settle();
    view = TestCamera{.size = {50, 60}}.view(standing);
    expect_same(moments_.at(1.0), view, "size");
    settle();
    TestWorld darker = room();
    darker.lights[0].intensity = 0.2f;
    expect_same(Moments(darker).at(1.0), view, "a light");
}

TEST_F(StaticLayer, ALampThatFlickersIsNothingToWhoDoesNotSeeWhatItShinesOn) {
    TestWorld lit = room();
    lit.lights.push_back(light_of(world::LightType::point, 3.0f, {5.0, 2.0, 0.6}));
    lit.lights.back().range = 1.5f;
    TestWorld dark = lit;
    dark.lights.back().intensity = 0.0f;
    const View sees = TestCamera{.eye = {0.0, 2.0, 0.0}, .size = {96, 64}, .focal_px = 200.0}.view(standing);
    const View aside = TestCamera{.eye = {0.0, -2.0, 0.0}, .size = {96, 64}, .focal_px = 200.0}.view(standing + 10);
    for (const View& view : {sees, aside}) cpu_renderer().forget(view.camera);
    const Moments moments(lit);
    const RenderCounters before = cpu_renderer().counters();
    for (int n = 0; n < 10; ++n) {
        const world::SnapshotRef now = flickered(*moments.at(0.3 * n), n % 2 == 0 ? dark.lights : lit.lights);
        const auto together = draw_views(now, std::array{sees, aside});
        for (std::size_t i = 0; i < 2; ++i) {
            cpu_renderer().forget(CameraId{fresh});
            const View alone = numbered(i == 0 ? sees : aside, fresh);
            EXPECT_TRUE(bytes_of({together[i]}) == bytes_of(draw_views(now, {&alone, 1}))) << i << ", picture " << n;
        }
    }
    const RenderCounters after = cpu_renderer().counters();
    if (cpu_renderer().is_on_cpu()) {
        EXPECT_EQ(after.layers_reused - before.layers_reused, 7u) << "all of the other one, once it is kept";
    }
    for (const View& view : {sees, aside}) cpu_renderer().forget(view.camera);
}

TEST_F(StaticLayer, ViewsOfAnInstantInTurnsShowWhatTheyShowTogether) {
    const TestCamera camera{.size = {97, 61}, .focal_px = 60.0, .quality = world::Quality::beautiful};
    TestCamera aside = camera;
    aside.eye.y += 0.7;
    const std::array views{all_kinds(camera.view(standing)), all_kinds(aside.view(fresh))};
    for (const double where : {0.0, 1.1, 2.2}) {
        const world::SnapshotRef moment = moments_.at(where);
        auto in_turns = bytes_of(draw_views(moment, {&views[0], 1}));
        const auto second = bytes_of(draw_views(moment, {&views[1], 1}));
        in_turns.insert(in_turns.end(), second.begin(), second.end());
        EXPECT_TRUE(in_turns == bytes_of(draw_views(moments_.at(where), views))) << where;
    }
    cpu_renderer().forget(CameraId{fresh});
}

TEST_F(StaticLayer, ShadowsOfMoversSideBySideFallOnEdgesOfAll) {
    // Each has a rectangle of its own, with edges of boxes in it.
    TestWorld world = room();
    world.lights = {light_of(world::LightType::directional, 0.8f, {}, glm::normalize(glm::dvec3(0.3, 0.1, -1.0)))};
    world.movers[1] = instance_of(model_of(box({0.3f, 0.3f, 0.5f}), colored({0.9f, 0.9f, 0.1f})), {}, 50);
    const world::SnapshotRef first = world.snapshot();
    const View view = TestCamera{.eye = {0.0, 0.0, 1.0},
                                 .size = {320, 200},
                                 .focal_px = 150.0,
                                 .antialias = world::Antialias::coverage,
                                 .quality = world::Quality::beautiful}
                          .view(standing);
    const std::uint64_t before = reused();
    for (int n = 0; n < 5; ++n) {
        auto snapshot = std::make_shared<world::Snapshot>(*first);
        for (auto& mover : snapshot->movers) mover.scale = 0.5;
        snapshot->movers[0].position = {4.7, 2.2 - 0.05 * n, 0.8};
        snapshot->movers[1].position = {4.7, -1.1 + 0.05 * n, 0.9};
        expect_same(snapshot, view, "picture " + std::to_string(n));
    }
    EXPECT_EQ(reused() - before, 3u);
}

TEST_F(StaticLayer, ACameraThatMovesKeepsNone) {
    View view = TestCamera{.size = {80, 60}}.view(standing);
    const RenderCounters before = cpu_renderer().counters();
    for (int n = 0; n < 5; ++n) {
        view.pose.position.y += 0.01;
        draw_views(moments_.at(0.0), {&view, 1});
    }
    const RenderCounters after = cpu_renderer().counters();
    EXPECT_EQ(after.layers_drawn, before.layers_drawn);
    EXPECT_EQ(after.layers_reused, before.layers_reused);
}

TEST_F(StaticLayer, MemoryIsCountedAndGivenBack) {
    const std::int64_t before = cpu_renderer().counters().layer_bytes;
    const View view = TestCamera{.size = {80, 60}}.view(standing);
    for (int n = 0; n < 3; ++n) draw_views(moments_.at(n), {&view, 1});
    EXPECT_EQ(cpu_renderer().counters().layer_bytes - before, 80 * 60 * (8 + 4))
        << "opaque colour and depth; finished colour";
    cpu_renderer().forget(CameraId{standing});
    EXPECT_EQ(cpu_renderer().counters().layer_bytes, before);
}

TEST_F(StaticLayer, WhenMemoryIsUsedUpTheRestIsDrawnInFull) {
    // Each takes 64 MB, and 32 MB with what is blended; two fit into the standard 256 MB.
    std::vector<View> views;
    for (std::uint32_t n = 0; n < 5; ++n)
        views.push_back(TestCamera{.size = {4096, 2048}, .quality = world::Quality::fast}.view(10 + n));
    for (int n = 0; n < 3; ++n) draw_views(moments_.at(n), views);
    EXPECT_LE(cpu_renderer().counters().layer_bytes, RendererOptions{}.static_layer_bytes);
    EXPECT_EQ(cpu_renderer().counters().layers, 2);
    for (const View& view : views) cpu_renderer().forget(view.camera);
}

}  // namespace
}  // namespace camrig::render
