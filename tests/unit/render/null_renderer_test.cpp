#include "core/render/null_renderer.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/render/renderer_factory.h"

namespace camrig::render {
namespace {

View view_of(std::uint32_t number, std::int64_t sequence, ImageSize size = {64, 48}) {
    auto spec = std::make_shared<world::CameraSpec>();
    spec->name = "c" + std::to_string(number);
    spec->size = size;
    View view;
    view.camera = CameraId{number};
    view.name = std::make_shared<const std::string>(spec->name);
    view.spec = spec;
    view.sequence = sequence;
    view.camera_number = number;
    return view;
}

world::SnapshotRef snapshot_at(TimeNs world_ns) {
    auto snapshot = std::make_shared<world::Snapshot>();
    snapshot->world_ns = world_ns;
    snapshot->statics = std::make_shared<world::StaticSet>();
    return snapshot;
}

std::unique_ptr<Renderer> null_renderer() {
    auto renderer = create_renderer({.device = "null", .pool = std::make_shared<frame::FramePool>()});
    EXPECT_TRUE(renderer.has_value());
    return std::move(*renderer);
}

TEST(NullRenderer, TheSameInstantGivesTheSameBytes) {
    auto renderer = null_renderer();
    const View view = view_of(3, 7);
    std::vector<frame::FrameRef> frames;
    for (int i = 0; i < 2; ++i) {
        frames.push_back(renderer->draw(snapshot_at(40 * ns_per_ms), 5, {&view, 1}).value().set.frames.at(0));
    }
    EXPECT_TRUE(std::ranges::equal(frames[0]->bytes(), frames[1]->bytes()));
}

TEST(NullRenderer, CameraSequenceAndTimeEachShowInThePicture) {
    EXPECT_NE(null_pattern_blue(1, 0, 0), null_pattern_blue(2, 0, 0));
    EXPECT_NE(null_pattern_blue(1, 0, 0), null_pattern_blue(1, 1, 0));
    EXPECT_NE(null_pattern_blue(1, 0, 0), null_pattern_blue(1, 0, 1));
}

TEST(NullRenderer, FramesAreOfTheirInstantInTheOrderOfTheViewsAndEachHasItsCost) {
    auto renderer = null_renderer();
    const std::vector<View> first{view_of(1, 10), view_of(2, 20)};
    const std::vector<View> second{view_of(2, 21)};
    const auto a = renderer->draw(snapshot_at(100), 1100, first);
    ASSERT_EQ(a->set.frames.size(), 2u);
    EXPECT_EQ(a->set.world_ns, 100);
    EXPECT_EQ(a->set.monotonic_ns, 1100);
    EXPECT_EQ(a->set.frames[0]->info().sequence, 10);
    EXPECT_EQ(*a->set.frames[1]->info().camera, "c2");
    ASSERT_EQ(a->cost_ns.size(), 2u);
    EXPECT_GT(a->cost_ns[1], 0);
    EXPECT_EQ(renderer->draw(snapshot_at(200), 1200, second)->set.frames.at(0)->info().sequence, 21);
}

TEST(NullRenderer, EveryWantedKindComesWithItsFormat) {
    auto renderer = null_renderer();
    View view = view_of(1, 0);
    std::ranges::fill(view.kinds, true);
    const auto finished = renderer->draw(snapshot_at(0), 0, {&view, 1});
    ASSERT_EQ(finished->set.frames.size(), 5u);
    EXPECT_EQ(finished->set.frames[1]->info().format, frame::PixelFormat::depth32f);
    EXPECT_EQ(finished->set.frames[2]->info().format, frame::PixelFormat::id32);
    EXPECT_EQ(finished->set.frames[4]->info().format, frame::PixelFormat::normal32f);
    for (const auto& frame : finished->set.frames) {
        EXPECT_EQ(frame->bytes().size(), bytes_of(frame->info().format, frame->info().size));
    }
}

}  // namespace
}  // namespace camrig::render
