#include "core/engine/rig.h"

#include <algorithm>
#include <utility>

#include <gtest/gtest.h>

#include "core/base/clock.h"
#include "core/render/null_renderer.h"
#include "tests/unit/engine/inline_lane.h"
#include "tests/unit/stream/fake_sink.h"

namespace camrig::engine::rig_test {
namespace {

/// A null renderer that notes which cameras it drew.
class NotingRenderer final : public render::Renderer {
public:
    NotingRenderer(const std::shared_ptr<frame::FramePool>& pool, std::vector<CameraId>& drawn)
        : null_(pool), drawn_(drawn) {}

    Result<Finished> draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                          std::span<const render::View> views) override {
        for (const render::View& view : views) drawn_.push_back(view.camera);
        return null_.draw(snapshot, monotonic_ns, views);
    }
    void forget(CameraId) override {}
    std::string description() const override { return null_.description(); }

private:
    render::NullRenderer null_;
    std::vector<CameraId>& drawn_;
};

/// A rig in real time whose thread is the test's: an instant of 20 cameras needs more than one turn.
class RigTest : public testing::Test {
protected:
    static constexpr std::size_t camera_count = 20;

    void SetUp() override {
        auto scene = std::make_shared<world::Scene>();
        made_after_ns = monotonic_now_ns();
        auto made = make_rig(scene, {}, std::make_unique<NotingRenderer>(pool, drawn), bus);
        ASSERT_TRUE(made) << made.error().message;
        made_before_ns = monotonic_now_ns();
        rig = std::move(*made);
        for (std::size_t i = 0; i < camera_count; ++i) {
            CreateCamera command{.name = name_of(i), .place = {}, .patch = {}};
            command.patch.size = ImageSize{16, 16};
            command.patch.rate = Rate::parse("1").value();
            ids.push_back(call(command).value().id);
            sinks.push_back(std::make_shared<stream::FakeSink>());
            subscriptions.push_back(bus.subscribe(name_of(i), {}, {"test", "", {}}, sinks.back(), {}).value());
        }
    }
    /// The instant after a second has begun, less than 1 ms late, and one turn of it is drawn.
    void begin_instant() {
        drawn.clear();
        for (TimeNs now_ns = made_after_ns + ns_per_s; drawn.empty() && now_ns <= made_before_ns + ns_per_s + ns_per_ms;
             now_ns += ns_per_ms)
            rig->tick(now_ns);
        ASSERT_FALSE(drawn.empty());
        ASSERT_LT(drawn.size(), camera_count);
        ASSERT_LE(rig->wake_time_ns(), monotonic_now_ns()) << "the rest is due at once";
    }
    void finish_instant() {
        for (int turn = 0; turn < 100 && rig->wake_time_ns() == 0; ++turn) rig->tick(monotonic_now_ns());
    }
    template <typename C>
    Result<typename C::Reply> call(C command) {
        std::optional<Result<typename C::Reply>> reply;
        Command request = Request<C>{std::move(command), [&](auto result) { reply = std::move(result); }};
        rig->apply(request);
        return std::move(reply).value();
    }
    static std::string name_of(std::size_t index) { return "camera" + std::to_string(index); }
    stream::CameraReport report_of(std::size_t index) {
        const auto cameras = call(GetStats{}).value().cameras;
        return *std::ranges::find(cameras, name_of(index), &stream::CameraReport::name);
    }

    TimeNs made_after_ns = 0, made_before_ns = 0;  ///< the world began between the two
    std::vector<CameraId> drawn;
    std::shared_ptr<frame::FramePool> pool = std::make_shared<frame::FramePool>();
    stream::LocalFrameBus bus{{1, pool}};
    std::vector<CameraId> ids;
    std::vector<std::shared_ptr<stream::FakeSink>> sinks;
    std::unique_ptr<Rig> rig;
    std::vector<stream::Subscription> subscriptions;
};

TEST_F(RigTest, CommandsAreAnsweredInTheMiddleOfAnInstant) {
    begin_instant();
    EXPECT_TRUE(call(GetWorld{}));
    EXPECT_EQ(report_of(0).due, report_of(0).rendered + report_of(0).dropped) << "the books balance in between";
    rig->tick(monotonic_now_ns());
    EXPECT_TRUE(sinks.front()->wait_for_units(1)) << "what is drawn goes out";
    EXPECT_TRUE(sinks.back()->units().empty());
    finish_instant();
    EXPECT_EQ(drawn, ids) << "each camera once, in order";
    for (std::size_t i = 0; i < camera_count; ++i) {
        ASSERT_TRUE(sinks[i]->wait_for_units(1)) << i;
        EXPECT_EQ(sinks[i]->units().front().info.world_ns, sinks[0]->units().front().info.world_ns);
        EXPECT_EQ(report_of(i).rendered, 1U);
    }
}

TEST_F(RigTest, OnTimeTwoPicturesGoOutBeforeTheNextIsDrawn) {
    begin_instant();
    EXPECT_EQ(drawn.size(), 2U);
    rig->tick(monotonic_now_ns());
    EXPECT_TRUE(sinks.front()->wait_for_units(1));
    EXPECT_EQ(drawn.size(), 4U);
}

TEST_F(RigTest, AnInstantThatBeginsLateIsDrawnInLargerTurns) {
    drawn.clear();
    rig->tick(made_before_ns + ns_per_s + 11 * ns_per_ms);
    EXPECT_EQ(drawn.size(), 5U) << "40 ms of views that are taken to cost 8";
    finish_instant();
    EXPECT_EQ(drawn, ids);
}

TEST_F(RigTest, PicturesOnRequestAreDrawnOneATurn) {
    subscriptions.clear();  // nobody reads
    drawn.clear();
    for (std::size_t i = 0; i < camera_count; ++i)
        rig->fetch({name_of(i), frame::FrameKind::color, 0, {}}, [](const Result<stream::MediaUnit>&) {});
    EXPECT_TRUE(drawn.empty()) << "asking draws nothing";
    for (std::size_t turn = 1; turn <= camera_count; ++turn) {
        ASSERT_LE(rig->wake_time_ns(), monotonic_now_ns());
        rig->tick(made_before_ns);
        ASSERT_EQ(drawn.size(), turn);
    }
    EXPECT_EQ(drawn, ids);
}

TEST_F(RigTest, APictureOnRequestWaitsWhenAReadersPictureIsDueSoonAndItHadItsShare) {
    subscriptions.resize(1);  // camera 0 is read, once a second
    drawn.clear();
    const auto ask = [&] {
        rig->fetch({name_of(5), frame::FrameKind::depth, 0, {}}, [](const Result<stream::MediaUnit>&) {});
    };
    ask();
    ask();
    const TimeNs soon_ns = made_after_ns + ns_per_s - ns_per_ms;
    rig->tick(soon_ns);
    EXPECT_EQ(drawn.size(), 1U) << "none was drawn lately";
    rig->tick(soon_ns);
    EXPECT_EQ(drawn.size(), 1U) << "it would make the reader's picture late";
    rig->tick(made_before_ns + ns_per_s);
    ASSERT_GE(drawn.size(), 2U);
    EXPECT_EQ(drawn[1], ids[0]) << "the reader's comes first";
}

TEST_F(RigTest, AWorldThatHasMuchToCatchUpDoesItInTurnsAndAnswersInBetween) {
    drawn.clear();
    const TimeNs later_ns = made_before_ns + 50 * 3600 * ns_per_s;
    rig->tick(later_ns);
    EXPECT_TRUE(drawn.empty()) << "18 million steps are more than a turn";
    EXPECT_EQ(rig->wake_time_ns(), 0);
    const auto state = call(GetWorld{});
    ASSERT_TRUE(state);
    const TimeNs first_ns = state->world_ns;
    EXPECT_LT(first_ns, 50 * 3600 * ns_per_s);
    CreateCamera command{.name = "late", .place = {}, .patch = {}};
    ASSERT_TRUE(call(command));
    rig->tick(later_ns);
    EXPECT_GT(call(GetWorld{})->world_ns, first_ns);
    EXPECT_TRUE(call(PauseWorld{}));
    rig->tick(later_ns);
    EXPECT_GT(rig->wake_time_ns(), monotonic_now_ns()) << "a paused world rests where it is";
}

TEST_F(RigTest, AWorldThatHasCaughtUpDrawsTheNewestInstantAndCountsTheOthers) {
    drawn.clear();
    const TimeNs later_ns = made_before_ns + 3600 * ns_per_s;
    for (int turn = 0; turn < 100'000 && drawn.empty(); ++turn) rig->tick(later_ns);
    EXPECT_FALSE(drawn.empty());
    while (rig->wake_time_ns() == 0) rig->tick(later_ns);
    const auto report = report_of(0);
    EXPECT_EQ(report.rendered, 1U);
    EXPECT_EQ(report.dropped, 3599U);
}

TEST_F(RigTest, ACameraThatIsDeletedInTheMiddleIsNotDrawn) {
    begin_instant();
    const std::size_t next = drawn.size();
    ASSERT_LT(next + 3, camera_count);
    std::vector<CameraId> expected = ids;
    // The last, one in the middle of those left, the next to be drawn, and one that is drawn already.
    for (const std::size_t gone : {camera_count - 1, next + 2, next, std::size_t{0}}) {
        ASSERT_TRUE(call(DeleteCamera{name_of(gone)}));
        if (gone != 0) expected.erase(expected.begin() + static_cast<std::ptrdiff_t>(gone));
    }
    finish_instant();
    EXPECT_EQ(drawn, expected) << "all others once, in order";
    EXPECT_GT(rig->wake_time_ns(), monotonic_now_ns()) << "the instant has ended";
    for (const std::size_t later : {next + 1, next + 3, camera_count - 2}) {
        ASSERT_TRUE(sinks[later]->wait_for_units(1)) << later;
        EXPECT_EQ(report_of(later).rendered, 1U) << later;
    }
}

TEST_F(RigTest, AChangeInTheMiddleShowsFromTheNextInstantOn) {
    begin_instant();
    const std::size_t last = camera_count - 1;
    SetCamera change{.name = name_of(last), .patch = {}};
    change.patch.optics = world::VerticalFov{0.5};
    const auto state = call(change);
    ASSERT_TRUE(state);
    finish_instant();
    ASSERT_TRUE(sinks[last]->wait_for_units(1));
    EXPECT_EQ(sinks[last]->units().front().info.world_ns, state->applied_ns - ns_per_s);
}

TEST_F(RigTest, AfterAPauseNothingMoreOfAnInstantComes) {
    begin_instant();
    const auto paused = call(PauseWorld{});
    ASSERT_TRUE(paused);
    EXPECT_EQ(drawn, ids);
    EXPECT_GT(rig->wake_time_ns(), monotonic_now_ns());
    EXPECT_EQ(report_of(camera_count - 1).rendered, 1U);
}

TEST_F(RigTest, ANewWorldInTheMiddleBeginsAtZero) {
    begin_instant();
    ASSERT_TRUE(call(LoadWorld{std::make_shared<world::Scene>()}));
    std::vector<CameraId> twice = ids;
    twice.insert(twice.end(), ids.begin(), ids.end());
    EXPECT_EQ(drawn, twice) << "the old world's instant went out first, then the new one's beginning";
    drawn.clear();
    rig->tick(monotonic_now_ns() + ns_per_s);
    finish_instant();
    EXPECT_EQ(drawn, ids);
}

/// Draws at once, or when the test says so.
class HoldableLane final : public InlineLane {
public:
    using InlineLane::InlineLane;
    void post(DrawTask task) override {
        if (is_held)
            tasks_.push_back(std::move(task));
        else
            InlineLane::post(std::move(task));
    }
    void draw() {
        for (DrawTask& task : std::exchange(tasks_, {})) InlineLane::post(std::move(task));
    }
    std::size_t tasks() const { return tasks_.size(); }

    bool is_held = false;

private:
    std::vector<DrawTask> tasks_;
};

/// A rig in lockstep with five cameras, one picture a second each, all read.
class SteppedRigTest : public testing::Test {
protected:
    void SetUp() override {
        const auto finished = std::make_shared<DrawnTasks>(max_draw_tasks);
        std::vector<std::unique_ptr<DrawLane>> lanes;
        auto made_lane = std::make_unique<HoldableLane>(std::make_unique<NotingRenderer>(pool, drawn), finished);
        lane = made_lane.get();
        lanes.push_back(std::move(made_lane));
        EngineOptions options;
        options.mode = RunMode::lockstep;
        rig =
            std::move(*Rig::create(std::make_shared<world::Scene>(), options, std::move(lanes), finished, bus, [] {}));
        for (const char* name : {"a", "b", "c", "d", "e"}) {
            CreateCamera command{.name = name, .place = {}, .patch = {}};
            command.patch.size = ImageSize{16, 16};
            command.patch.rate = Rate::parse("1").value();
            Command request = Request<CreateCamera>{std::move(command), [](auto made) { ASSERT_TRUE(made); }};
            rig->apply(request);
            sinks.push_back(std::make_shared<stream::FakeSink>());
            subscriptions.push_back(bus.subscribe(name, {}, {"test", "", {}}, sinks.back(), {}).value());
        }
        drawn.clear();
    }
    void step(TimeNs duration_ns, TimeNs timeout_ns = 10 * ns_per_s) {
        Command request = Request<StepWorld>{{duration_ns, timeout_ns}, [this](auto result) { reply = result; }};
        rig->apply(request);
    }

    std::vector<CameraId> drawn;
    std::shared_ptr<frame::FramePool> pool = std::make_shared<frame::FramePool>();
    stream::LocalFrameBus bus{{1, pool}};
    HoldableLane* lane = nullptr;
    std::vector<std::shared_ptr<stream::FakeSink>> sinks;
    std::optional<Result<WorldState>> reply;  ///< a rig that ends answers who still waits
    std::unique_ptr<Rig> rig;
    std::vector<stream::Subscription> subscriptions;
};

TEST_F(SteppedRigTest, WhileAStepIsDrawnTheEngineSleeps) {
    lane->is_held = true;
    step(ns_per_s);
    rig->tick(monotonic_now_ns());
    ASSERT_EQ(lane->tasks(), 1U);
    EXPECT_GT(rig->wake_time_ns(), monotonic_now_ns() + ns_per_s) << "it hears of what is drawn";
    lane->draw();
    EXPECT_EQ(rig->wake_time_ns(), 0);
}

TEST_F(SteppedRigTest, WhileAPictureOnRequestWaitsForTheLaneTheEngineSleeps) {
    lane->is_held = true;
    step(ns_per_s);
    rig->tick(monotonic_now_ns());
    ASSERT_EQ(lane->tasks(), 1U);
    rig->fetch({"a", frame::FrameKind::depth, 0, {}}, [](const Result<stream::MediaUnit>&) {});
    rig->tick(monotonic_now_ns());
    EXPECT_GT(rig->wake_time_ns(), monotonic_now_ns() + ns_per_s) << "the lane tells when it is free";
}

TEST_F(SteppedRigTest, WhatIsBeingDrawnOfAStepThatIsGivenUpStillGoesOut) {
    sinks.front()->keep_holds();
    lane->is_held = true;
    step(2 * ns_per_s, ns_per_s);
    while (drawn.size() < sinks.size()) {
        rig->tick(monotonic_now_ns());
        lane->draw();
    }
    rig->tick(monotonic_now_ns());  // sends the first instant, which stays on its way
    for (const auto& sink : sinks) ASSERT_TRUE(sink->wait_for_units(1));
    rig->tick(monotonic_now_ns());  // begins the second
    ASSERT_FALSE(reply);
    lane->is_held = false;
    lane->draw();
    ASSERT_LT(drawn.size(), 2 * sinks.size());
    rig->tick(monotonic_now_ns() + 2 * ns_per_s);
    ASSERT_TRUE(reply);
    EXPECT_FALSE(*reply);
    for (const auto& sink : sinks) EXPECT_TRUE(sink->wait_for_units(2));
}

TEST(CameraTable, APictureThatIsFrozenKeepsTheOtherPartThatItWasTornWith) {
    CameraTable cameras;
    world::CameraSpec spec;
    spec.name = "lobby";
    spec.size = {16, 16};
    CameraEntry& entry = *cameras.add(spec).value();
    const auto set = [&](fault::FaultKind kind, TimeNs begin_ns) {
        ASSERT_TRUE(cameras.set_fault(entry, {.kind = std::move(kind), .begin_ns = begin_ns, .end_ns = {}}, 0, 0));
    };
    set(fault::Tearing{.share = 0.5}, 0);
    set(fault::Freeze{}, 3 * ns_per_s);
    const auto world = std::move(*world::World::create(std::make_shared<world::Scene>(), 1));
    for (std::int64_t n = 0; n < 5; ++n) {
        world->advance_to(n * ns_per_s);
        cameras.show(entry, n, world->snapshot(n * ns_per_s), n * ns_per_s);
    }
    ASSERT_TRUE(entry.latest.shown) << "it is frozen";
    EXPECT_EQ(entry.latest.shown->sequence, 3);
    ASSERT_TRUE(entry.latest.shown->torn_with);
    EXPECT_EQ(entry.latest.shown->torn_with->sequence, 2) << "and not itself";
}

TEST(CameraTable, WhatWasFoundForACamerasTruthsGoesWithIt) {
    CameraTable cameras;
    world::CameraSpec spec;
    spec.name = "lobby";
    const std::weak_ptr<truth::StandingObjects> found = cameras.add(spec).value()->standing;
    ASSERT_FALSE(found.expired());
    std::ignore = cameras.remove("lobby");
    EXPECT_TRUE(found.expired());
}

}  // namespace
}  // namespace camrig::engine::rig_test
