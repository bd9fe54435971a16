#include "core/engine/draw_desk.h"

#include <map>
#include <new>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/camera/lens_map.h"
#include "core/render/composed_renderer.h"
#include "core/render/null_renderer.h"

namespace camrig::engine::draw_desk_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// What every renderer of these tests is, by another one.
class Wrapped : public render::Renderer {
public:
    explicit Wrapped(std::unique_ptr<render::Renderer> inner) : inner_(std::move(inner)) {}

    Result<Finished> draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                          std::span<const render::View> views) override {
        return inner_->draw(snapshot, monotonic_ns, views);
    }
    bool is_plain(const render::View& view) const override { return inner_->is_plain(view); }
    TimeNs expected_cost_ns(const render::View& view) const override { return inner_->expected_cost_ns(view); }
    void forget(CameraId camera) override { inner_->forget(camera); }
    void hand_over(CameraId camera) override { inner_->hand_over(camera); }
    render::RenderCounters counters() const override { return inner_->counters(); }
    std::string description() const override { return inner_->description(); }

private:
    std::unique_ptr<render::Renderer> inner_;
};

/// Beautiful pictures are not plain, as with the renderers of CPUs.
class Quick final : public Wrapped {
public:
    using Wrapped::Wrapped;
    bool is_plain(const render::View& view) const override { return view.quality != world::Quality::beautiful; }
};

/// A picture drawn in full costs 50 ms, one of which a layer is kept and a small one 2 ms.
class Priced final : public Wrapped {
public:
    using Wrapped::Wrapped;
    Result<Finished> draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                          std::span<const render::View> views) override {
        const std::uint64_t before = counters().views_in_parts;
        auto finished = Wrapped::draw(snapshot, monotonic_ns, views);
        const bool is_in_full = counters().views_in_parts == before;
        for (std::size_t i = 0; i < views.size(); ++i)
            finished->cost_ns[i] = (is_in_full && views[i].spec->size.width > 16 ? 50 : 2) * ns_per_ms;
        return finished;
    }
};

/// A picture costs what its camera's next number says, the last one from then on.
class Listed final : public Wrapped {
public:
    using Costs = std::map<CameraId, std::vector<TimeNs>>;
    Listed(std::unique_ptr<render::Renderer> inner, Costs& costs) : Wrapped(std::move(inner)), costs_(costs) {}
    Result<Finished> draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                          std::span<const render::View> views) override {
        auto finished = Wrapped::draw(snapshot, monotonic_ns, views);
        for (std::size_t i = 0; i < views.size(); ++i) {
            auto& costs = costs_[views[i].camera];
            finished->cost_ns[i] = costs.front();
            if (costs.size() > 1) costs.erase(costs.begin());
        }
        return finished;
    }

private:
    Costs& costs_;
};

/// Draws nothing: there is no memory.
class Exhausted final : public Wrapped {
public:
    using Wrapped::Wrapped;
    Result<Finished> draw(const world::SnapshotRef&, TimeNs, std::span<const render::View>) override {
        throw std::bad_alloc();
    }
};

/// A lane that draws when the test says so, on its thread; any task takes a microsecond.
class HeldLane final : public DrawLane {
public:
    HeldLane(std::unique_ptr<render::Renderer> renderer, std::shared_ptr<DrawnTasks> drawn)
        : renderer_(std::move(renderer)), drawn_(std::move(drawn)) {}

    void post(DrawTask task) override { tasks_.push_back(std::move(task)); }
    render::RenderCounters counters() const override { return renderer_->counters(); }
    bool makes(frame::PixelFormat format, const render::View&) const override {
        return format == frame::PixelFormat::rgba8;
    }
    bool is_plain(const render::View& view) const override { return renderer_->is_plain(view); }
    TimeNs expected_cost_ns(const render::View& view) const override { return renderer_->expected_cost_ns(view); }
    bool wants_second() const override { return true; }
    const std::string& description() const override { return description_; }

    /// Draws all that was posted.
    void draw() {
        for (DrawTask& task : tasks_) {
            task.draw(*renderer_);
            drawn_->put([done = std::move(task.done)] { done(ns_per_us); });
        }
        tasks_.clear();
    }
    std::size_t tasks() const { return tasks_.size(); }

private:
    std::unique_ptr<render::Renderer> renderer_;
    std::shared_ptr<DrawnTasks> drawn_;
    std::string description_ = "held";
    std::vector<DrawTask> tasks_;
};

class DrawDeskTest : public testing::Test {
protected:
    virtual std::unique_ptr<render::Renderer> make_renderer() {
        return std::make_unique<Quick>(std::make_unique<render::NullRenderer>(pool));
    }
    void SetUp() override {
        std::vector<std::unique_ptr<DrawLane>> lanes;
        for (HeldLane*& lane : lane_) {
            auto made = std::make_unique<HeldLane>(make_renderer(), finished);
            lane = made.get();
            lanes.push_back(std::move(made));
        }
        desk = std::make_unique<DrawDesk>(
            std::move(lanes), finished,
            DrawDesk::Callbacks{.drawn =
                                    [this](DrawnViews& views) {
                                        for (const render::View& view : views.due.views)
                                            drawn.emplace_back(*view.name, view.sequence);
                                        for (const auto& failure : views.failures) failed.push_back(failure.error.kind);
                                    },
                                .dropped = [this](const DueViews&, const render::View& view,
                                                  stream::DropReason why) { dropped.emplace_back(*view.name, why); },
                                .next_request = [this]() -> std::optional<DrawTask> {
                                    if (requests == 0) return std::nullopt;
                                    --requests;
                                    return DrawTask{[](render::Renderer&) {}, [this](TimeNs) { ++answered; }};
                                }});
    }
    render::View view(std::uint32_t camera, world::Quality quality = world::Quality::simple,
                      const std::string& group = {}, ImageSize size = {16, 16}, const camera::Lens& lens = {}) {
        auto spec = std::make_shared<world::CameraSpec>();
        spec->size = size;
        spec->lens = lens;
        spec->intrinsics = {0.5 * size.width, 0.5 * size.width, 0.5 * (size.width - 1), 0.5 * (size.height - 1)};
        spec->group = group;
        render::View made;
        made.camera = CameraId(camera);
        made.name = std::make_shared<const std::string>("c" + std::to_string(camera));
        made.spec = std::move(spec);
        made.quality = quality;
        made.sequence = instant;
        return made;
    }
    /// The next instant of these cameras is due.
    void fall_due(std::vector<render::View> views) {
        auto snapshot = std::make_shared<world::Snapshot>();
        snapshot->world_ns = instant++;
        snapshot->statics = statics;
        desk->add({std::move(snapshot), now_ns, std::move(views), true});
        desk->dispatch(now_ns);
    }
    void take_finished() {
        desk->take_finished();
        desk->dispatch(now_ns);
    }

    using Drawn = std::pair<std::string, std::int64_t>;
    std::shared_ptr<frame::FramePool> pool = std::make_shared<frame::FramePool>();
    std::shared_ptr<DrawnTasks> finished = std::make_shared<DrawnTasks>(max_draw_tasks);
    std::shared_ptr<const world::StaticSet> statics = std::make_shared<world::StaticSet>();
    static constexpr TimeNs now_ns = 0;  ///< no instant is late, however busy the machine is
    std::array<HeldLane*, 2> lane_{};
    std::vector<Drawn> drawn;
    std::vector<std::pair<std::string, stream::DropReason>> dropped;
    std::vector<ErrorKind> failed;
    int requests = 0, answered = 0;
    std::int64_t instant = 0;
    std::unique_ptr<DrawDesk> desk;
};

TEST_F(DrawDeskTest, ADearPictureStopsNobodyElse) {
    for (int i = 0; i < 10; ++i) {
        fall_due({view(1), view(2, world::Quality::beautiful)});
        lane_[0]->draw();
        take_finished();
    }
    EXPECT_EQ(drawn.size(), 10U) << "all of the plain camera";
    EXPECT_EQ(lane_[1]->tasks(), 1U) << "the dear one's first is still being drawn";
    EXPECT_EQ(dropped.size(), 8U) << "of the others its newest waits";
    lane_[1]->draw();
    take_finished();
    EXPECT_EQ(drawn.back(), Drawn("c2", 0));
    lane_[1]->draw();
    take_finished();
    EXPECT_EQ(drawn.back(), Drawn("c2", 9));
    EXPECT_TRUE(desk->is_idle());
}

TEST_F(DrawDeskTest, TheBooksSayWhoseCostItWas) {
    fall_due({view(1), view(2, world::Quality::beautiful)});
    for (HeldLane* lane : lane_) lane->draw();
    take_finished();
    for (int i = 0; i < 3; ++i) fall_due({view(1), view(2, world::Quality::beautiful)});
    EXPECT_THAT(dropped, ElementsAre(std::pair("c1", stream::DropReason::overload),
                                     std::pair("c2", stream::DropReason::own_cost)));
}

TEST_F(DrawDeskTest, ACamerasPicturesComeOutInTheirOrderWhateverTheyCost) {
    fall_due({view(1, world::Quality::beautiful)});
    fall_due({view(1, world::Quality::simple)});  // plain now: yet it stays behind the one that is being drawn
    EXPECT_EQ(lane_[0]->tasks(), 0U);
    for (int turn = 0; turn < 2; ++turn) {
        lane_[1]->draw();
        take_finished();
    }
    EXPECT_THAT(drawn, ElementsAre(Drawn("c1", 0), Drawn("c1", 1)));
    fall_due({view(1, world::Quality::simple)});
    EXPECT_EQ(lane_[0]->tasks(), 1U) << "from then on it is drawn among the quick ones";
}

TEST_F(DrawDeskTest, AGroupIsDrawnOrDroppedTogether) {
    const auto pair_due = [&] {
        fall_due({view(1), view(2, world::Quality::simple, "pair"), view(3, world::Quality::beautiful, "pair")});
    };
    for (int i = 0; i < 20; ++i) {
        pair_due();
        lane_[0]->draw();
        if (i % 3 == 0) lane_[1]->draw();
        take_finished();
    }
    while (!desk->is_idle()) {
        for (HeldLane* lane : lane_) lane->draw();
        take_finished();
    }
    std::map<std::string, std::vector<std::int64_t>> of;
    for (const auto& [name, sequence] : drawn) of[name].push_back(sequence);
    EXPECT_EQ(of["c1"].size(), 20U);
    EXPECT_EQ(of["c2"], of["c3"]);
    EXPECT_LT(of["c2"].size(), 20U) << "they had too little time";
    EXPECT_GT(of["c2"].size(), 3U);
}

TEST_F(DrawDeskTest, WhoLeavesAGroupIsDrawnOnItsOwn) {
    fall_due({view(1, world::Quality::simple, "pair"), view(2, world::Quality::beautiful, "pair")});
    EXPECT_EQ(lane_[0]->tasks(), 0U);
    for (int turn = 0; turn < 2; ++turn) {
        lane_[1]->draw();
        take_finished();
    }
    fall_due({view(1)});
    EXPECT_EQ(lane_[0]->tasks(), 1U);
    desk->forget(CameraId(2));
    desk->forget(CameraId(1));
    lane_[0]->draw();
    take_finished();
    EXPECT_TRUE(desk->is_idle());
}

TEST_F(DrawDeskTest, RequestsAreDrawnBesideRunningCameras) {
    requests = 2;
    desk->set_requests(true);
    desk->dispatch(now_ns);
    fall_due({view(1)});
    EXPECT_EQ(lane_[0]->tasks(), 1U);
    EXPECT_EQ(lane_[1]->tasks(), 1U);
    for (int turn = 0; turn < 2; ++turn) {
        lane_[1]->draw();
        take_finished();
    }
    EXPECT_EQ(answered, 2);
    EXPECT_FALSE(desk->is_idle()) << "the camera's picture is still to come";
}

TEST_F(DrawDeskTest, ACameraThatGoesInTheMiddleLeavesNothingAtWork) {
    fall_due({view(1), view(2), view(3), view(4), view(5)});
    desk->forget(CameraId(1));  // being drawn
    desk->forget(CameraId(5));  // waiting
    for (int turn = 0; turn < 3; ++turn) {
        lane_[0]->draw();
        take_finished();
    }
    EXPECT_TRUE(desk->is_idle());
    EXPECT_THAT(dropped, IsEmpty());
    EXPECT_EQ(drawn.size(), 4U) << "what was being drawn is heard of";
}
class ExhaustedDrawDeskTest : public DrawDeskTest {
protected:
    std::unique_ptr<render::Renderer> make_renderer() override {
        return std::make_unique<Exhausted>(std::make_unique<render::NullRenderer>(pool));
    }
};

TEST_F(ExhaustedDrawDeskTest, MemoryThatRunsOutIsAnErrorOfEachPictureAndNotTheEnd) {
    fall_due({view(1), view(2)});
    lane_[0]->draw();
    take_finished();
    EXPECT_THAT(failed, ElementsAre(ErrorKind::resource_exhausted, ErrorKind::resource_exhausted));
    EXPECT_TRUE(desk->is_idle());
}

class ListedDrawDeskTest : public DrawDeskTest {
protected:
    std::unique_ptr<render::Renderer> make_renderer() override {
        return std::make_unique<Listed>(std::make_unique<render::NullRenderer>(pool), costs);
    }
    /// More instants than can be drawn: a lane has drawn a turn when the third one is due.
    void run(int instants) {
        for (int i = 0; i < instants; ++i) {
            std::vector<render::View> views;
            for (std::uint32_t camera = 1; camera <= costs.size(); ++camera) views.push_back(view(camera));
            fall_due(std::move(views));
            if (i % 3 != 0) continue;
            for (HeldLane* lane : lane_) lane->draw();
            take_finished();
        }
    }
    /// What waits is drawn, too.
    std::map<std::string, std::vector<std::int64_t>> drawn_of_each() {
        while (!desk->is_idle()) {
            for (HeldLane* lane : lane_) lane->draw();
            take_finished();
        }
        std::map<std::string, std::vector<std::int64_t>> of;
        for (const auto& [name, sequence] : drawn) of[name].push_back(sequence);
        return of;
    }
    Listed::Costs costs;
};

TEST_F(ListedDrawDeskTest, CamerasOfLikeCostLoseTheSameInstants) {
    // About the bound of two classes, on either side of it.
    for (std::uint32_t camera = 1; camera <= 8; ++camera)
        costs[CameraId(camera)] = {(3'700 + 100 * std::int64_t{camera}) * ns_per_us};
    run(60);
    drawn.clear();
    run(200);
    const auto of = drawn_of_each();
    EXPECT_GT(of.at("c1").size(), 10U);
    EXPECT_LT(of.at("c1").size(), 150U) << "not more than can be drawn";
    for (const auto& [name, sequences] : of) EXPECT_EQ(sequences, of.at("c1")) << name;
}

TEST_F(ListedDrawDeskTest, WhoAlwaysHasSomethingToDrawComesToTheClassOfItsCost) {
    for (std::uint32_t camera = 1; camera <= 6; ++camera) costs[CameraId(camera)] = {2 * ns_per_ms};
    // Their first pictures took longer: something was made for them.
    for (std::uint32_t camera = 7; camera <= 8; ++camera)
        costs[CameraId(camera)] = {10 * ns_per_ms, 10 * ns_per_ms, 10 * ns_per_ms, 10 * ns_per_ms, 2 * ns_per_ms};
    run(1);
    drawn_of_each();  // from now on they are drawn among the dearer ones
    run(60);
    drawn.clear();
    run(200);
    const auto of = drawn_of_each();
    EXPECT_GT(of.at("c1").size(), 10U);
    for (const auto& [name, sequences] : of) EXPECT_EQ(sequences, of.at("c1")) << name;
    EXPECT_TRUE(desk->is_idle());
}

/// With the renderer of a machine without a GPU.
class CpuDrawDeskTest : public DrawDeskTest {
protected:
    std::unique_ptr<render::Renderer> make_renderer() override {
        render::software::SoftwareDrawer::Options options{
            .pool = pool, .caches = caches, .static_layer_bytes = 1 << 28};
        return std::make_unique<Priced>(std::make_unique<render::ComposedRenderer>(
            options, [] { return error(ErrorKind::unsupported, "nothing here is drawn elsewhere"); }));
    }
    render::SharedCaches caches = render::make_shared_caches();
};

TEST_F(CpuDrawDeskTest, WhatIsDearIsNeverDrawnBeforeWhoRunsAlready) {
    const camera::Lens barrel =
        camera::make_lens(camera::LensModel::plumb_bob, std::vector{-0.25, 0.05, 0.001, -0.001, 0.0}).value();
    for (int i = 0; i < 5; ++i) {
        fall_due({view(1), view(2, world::Quality::beautiful), view(3, world::Quality::simple, {}, {1920, 1080}),
                  view(4, world::Quality::simple, {}, {640, 480}, barrel)});
        lane_[0]->draw();
        take_finished();
    }
    EXPECT_EQ(drawn.size(), 5U);
    for (const auto& [name, sequence] : drawn) EXPECT_EQ(name, "c1");
}

TEST_F(CpuDrawDeskTest, WhoTurnsOutToBeCheapComesToTheQuickOnesWithItsLayer) {
    const auto due = [&] { fall_due({view(3, world::Quality::simple, {}, {640, 480})}); };
    for (int i = 0; i < 3; ++i) {
        due();
        EXPECT_EQ(lane_[0]->tasks(), 0U) << "picture " << i;
        for (HeldLane* lane : lane_) lane->draw();
        take_finished();
    }
    for (HeldLane* lane : lane_) lane->draw();
    for (int i = 0; i < 6; ++i) {
        due();
        EXPECT_EQ(lane_[0]->tasks(), 1U);
        for (HeldLane* lane : lane_) lane->draw();
        take_finished();
    }
    EXPECT_EQ(lane_[0]->counters().views_in_parts, 6U);
    EXPECT_EQ(lane_[0]->counters().layers_drawn, 0U) << "drawn in the other lane";
    EXPECT_EQ(lane_[1]->counters().layer_bytes, 0);
    EXPECT_GT(lane_[0]->counters().layer_bytes, 0);
}

}  // namespace
}  // namespace camrig::engine::draw_desk_test
