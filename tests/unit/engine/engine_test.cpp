#include "core/engine/engine.h"

#include <chrono>
#include <filesystem>
#include <future>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/frame/code_strip.h"
#include "tests/unit/stream/fake_sink.h"

namespace camrig::engine::engine_test {
namespace {

constexpr stream::MediaFormat raw{};

/// A rig with an empty world and the null renderer: everything but GL is the real thing.
class EngineTest : public testing::Test {
protected:
    void start(RunMode mode, OverloadPolicy overload = OverloadPolicy::drop) {
        auto scene = std::make_shared<world::Scene>();
        scene->name = "empty";
        EngineOptions options;
        options.mode = mode;
        options.overload = overload;
        options.renderer.device = "null";
        options.renderer.pool = pool;
        auto started = Engine::start(scene, options, bus);
        ASSERT_TRUE(started) << started.error().message;
        engine = std::move(*started);
    }
    template <typename C>
    Result<typename C::Reply> call(C command) {
        std::promise<Result<typename C::Reply>> promise;
        auto reply = promise.get_future();
        engine->post(Request<C>{std::move(command), [&](auto result) { promise.set_value(std::move(result)); }});
        return reply.get();
    }
    Result<stream::MediaUnit> fetch(const std::string& camera, TimeNs min_ns = 0) {
        std::promise<Result<stream::MediaUnit>> promise;
        auto reply = promise.get_future();
        engine->fetch({camera, frame::FrameKind::color, min_ns, raw},
                      [&](auto result) { promise.set_value(std::move(result)); });
        return reply.get();
    }
    Result<CameraReply> create(const std::string& name, const char* fps = "25", bool code_strip = false) {
        CreateCamera command;
        command.name = name;
        command.patch.size = ImageSize{160, 120};
        command.patch.rate = Rate::parse(fps).value();
        command.patch.change([code_strip](world::CameraSpec& spec) { spec.code_strip = code_strip; });
        return call(command);
    }
    Result<WorldState> step(TimeNs duration_ns, TimeNs timeout_ns = 20 * ns_per_s) {
        return call(StepWorld{duration_ns, timeout_ns});
    }
    std::shared_ptr<stream::FakeSink> watch(const std::string& camera,
                                            std::vector<stream::Subscription>& subscriptions) {
        auto sink = std::make_shared<stream::FakeSink>();
        subscriptions.push_back(bus.subscribe(camera, raw, {"test", camera, {}}, sink, {}).value());
        return sink;
    }

    std::shared_ptr<frame::FramePool> pool = std::make_shared<frame::FramePool>();
    stream::LocalFrameBus bus{{2, pool}};
    std::unique_ptr<Engine> engine;
};

TEST_F(EngineTest, ANewCameraShowsTheMomentItWasMade) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a"));
    const auto first = fetch("a");
    ASSERT_TRUE(first) << first.error().message;
    EXPECT_EQ(first->info.sequence, 0);
    EXPECT_EQ(first->info.world_ns, 0);
}

TEST_F(EngineTest, PicturesOfAHeldInstantAreAllOfItAndNoneOfTheCamerasFrames) {
    start(RunMode::realtime);
    ASSERT_TRUE(create("a", "25", true));
    ASSERT_TRUE(create("b", "10", true));
    std::vector<stream::Subscription> subscriptions;
    auto reader = watch("a", subscriptions);
    const auto picture = [&](const std::string& camera, frame::FrameKind kind, stream::InstantRef of) {
        std::promise<Result<stream::MediaUnit>> promise;
        stream::FetchRequest request{
            .camera = camera, .kind = kind, .min_ns = 0, .format = raw, .instant = std::move(of)};
        if (kind == frame::FrameKind::depth) request.format.pixels = frame::PixelFormat::depth32f;
        engine->fetch(std::move(request), [&](auto result) { promise.set_value(std::move(result)); });
        return promise.get_future().get();
    };
    const auto held = call(GetInstant{}).value();
    ASSERT_TRUE(fetch("a", held->snapshot->world_ns + 200 * ns_per_ms));  // the world has gone on since
    for (const char* camera : {"a", "b", "a"})
        for (const auto kind : {frame::FrameKind::color, frame::FrameKind::depth}) {
            const auto unit = picture(camera, kind, held);
            ASSERT_TRUE(unit) << unit.error().message;
            EXPECT_EQ(unit->info.world_ns, held->snapshot->world_ns);
            EXPECT_EQ(unit->info.sequence, held->sequence);
        }
    EXPECT_NE(call(GetInstant{}).value()->sequence, held->sequence);
    EXPECT_LT(held->sequence, 0);
    for (const auto& unit : reader->units()) EXPECT_GE(unit.info.sequence, 0);
    // Of another world there are none.
    auto other = std::make_shared<world::Scene>();
    ASSERT_TRUE(call(LoadWorld{other}));
    const auto refused = picture("a", frame::FrameKind::color, held);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::unavailable);
}

TEST_F(EngineTest, LockstepDeliversEveryDueFrameAndOneStampPerInstant) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a", "25", true));
    ASSERT_TRUE(create("b", "10", true));
    std::vector<stream::Subscription> subscriptions;
    auto a = watch("a", subscriptions), b = watch("b", subscriptions);
    ASSERT_TRUE(step(ns_per_s));
    const auto a_units = a->units(), b_units = b->units();
    ASSERT_EQ(a_units.size(), 25u);
    ASSERT_EQ(b_units.size(), 10u);
    for (std::size_t i = 0; i < 25; ++i) {
        EXPECT_EQ(a_units[i].info.world_ns, static_cast<TimeNs>(i + 1) * 40 * ns_per_ms);
        EXPECT_EQ(a_units[i].info.sequence, static_cast<std::int64_t>(i + 1));
        const auto code = frame::read_code_strip(a_units[i].frame->bytes(), a_units[i].info.size);
        ASSERT_TRUE(code);
        EXPECT_EQ(code->world_ns, a_units[i].info.world_ns);
    }
    for (const auto& unit : b_units) {
        if (unit.info.world_ns % (40 * ns_per_ms) != 0) continue;
        const auto& twin = a_units[static_cast<std::size_t>(unit.info.world_ns / (40 * ns_per_ms) - 1)];
        EXPECT_EQ(unit.info.monotonic_ns, twin.info.monotonic_ns);
    }
    const auto report = call(GetStats{}).value();
    for (const auto& camera : report.cameras) {
        EXPECT_EQ(camera.due, camera.rendered);
        EXPECT_EQ(camera.dropped, 0u);
    }
}

TEST_F(EngineTest, AnOutputGoesWithItsLastReader) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a"));
    const auto outputs = [this] { return call(GetStats{})->cameras.at(0).outputs.size(); };
    std::vector<stream::Subscription> subscriptions;
    const auto first = watch("a", subscriptions), second = watch("a", subscriptions);
    EXPECT_EQ(outputs(), 1U) << "both take the same pictures";
    subscriptions.pop_back();
    EXPECT_EQ(outputs(), 1U);
    subscriptions.clear();
    EXPECT_EQ(outputs(), 0U);
}

TEST_F(EngineTest, AStuckReaderFailsTheStepAndIsNamed) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a"));
    std::vector<stream::Subscription> subscriptions;
    auto sink = watch("a", subscriptions);
    sink->keep_holds();
    const auto result = step(ns_per_s, 50 * ns_per_ms);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, ErrorKind::unavailable);
    EXPECT_THAT(result.error().message, testing::HasSubstr("fake reader"));
    subscriptions.clear();
    EXPECT_TRUE(step(ns_per_s));
}

TEST_F(EngineTest, AReaderMayLetGoOfAFrameWhenTheEngineIsGone) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a"));
    std::vector<stream::Subscription> subscriptions;
    auto sink = watch("a", subscriptions);
    sink->keep_holds();
    ASSERT_FALSE(step(ns_per_s, 50 * ns_per_ms));
    engine.reset();
    sink->release_holds();  // the last hold wakes the one who waited: nothing may be touched that is gone (sanitizers)
}

TEST_F(EngineTest, ACameraNobodyWatchesIsNotDrawn) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a"));
    ASSERT_TRUE(step(ns_per_s));
    const auto report = call(GetStats{}).value();
    EXPECT_EQ(report.cameras.at(0).idle, 25u);
    EXPECT_EQ(report.cameras.at(0).rendered, 0u);
    // Yet its latest due picture is there for who asks.
    EXPECT_EQ(fetch("a")->info.sequence, 25);
}

TEST_F(EngineTest, InLockstepReadersSeeNoGapWhereACameraWasChanged) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a"));
    std::vector<stream::Subscription> subscriptions;
    const auto sink = watch("a", subscriptions);
    ASSERT_TRUE(step(80 * ns_per_ms));
    const auto before = fetch("a").value();
    SetCamera command{"a", {}};
    command.patch.optics = world::VerticalFov{0.5};
    ASSERT_TRUE(call(command));
    const auto changed = fetch("a").value();
    EXPECT_EQ(changed.info.sequence, before.info.sequence) << "the same instant anew";
    EXPECT_NE(changed.frame, before.frame);
    ASSERT_TRUE(step(80 * ns_per_ms));
    std::vector<std::int64_t> numbers;
    for (const auto& unit : sink->units()) numbers.push_back(unit.info.sequence);
    EXPECT_EQ(numbers, (std::vector<std::int64_t>{1, 2, 3, 4}));
}

TEST_F(EngineTest, ANewWorldIsShownToReadersAtOnceAndLeavesNoGap) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a"));
    std::vector<stream::Subscription> subscriptions;
    const auto sink = watch("a", subscriptions);
    ASSERT_TRUE(step(80 * ns_per_ms));
    ASSERT_TRUE(call(LoadWorld{std::make_shared<world::Scene>()}));
    ASSERT_TRUE(sink->wait_for_units(3));
    ASSERT_TRUE(step(40 * ns_per_ms));
    std::vector<std::int64_t> numbers;
    std::vector<TimeNs> times;
    for (const auto& unit : sink->units()) {
        numbers.push_back(unit.info.sequence);
        times.push_back(unit.info.world_ns / ns_per_ms);
    }
    EXPECT_EQ(numbers, (std::vector<std::int64_t>{1, 2, 3, 4}));
    EXPECT_EQ(times, (std::vector<TimeNs>{40, 80, 0, 40}));
}

TEST_F(EngineTest, AWorldWithACameraThatCannotBeChangesNothing) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a"));
    ASSERT_TRUE(step(ns_per_s));
    auto scene = std::make_shared<world::Scene>();
    scene->name = "other";
    for (const char* name : {"good", "large", "as_large", "too_much"}) {
        world::CameraSpec& spec = scene->cameras.emplace_back();
        spec.name = name;
        if (spec.name != "good") spec.size = ImageSize{8192, 8192};
    }
    const auto loaded = call(LoadWorld{scene});
    ASSERT_FALSE(loaded);
    EXPECT_EQ(loaded.error().kind, ErrorKind::resource_exhausted);
    EXPECT_THAT(loaded.error().message, testing::HasSubstr("camera too_much: all cameras together"));
    EXPECT_EQ(call(GetWorld{})->scene, "empty");
    EXPECT_EQ(call(GetWorld{})->world_ns, ns_per_s);
    EXPECT_EQ(call(ListCameras{})->size(), 1u);
    EXPECT_EQ(bus.cameras().size(), 1u);

    auto fits = std::make_shared<world::Scene>(*scene);
    fits->cameras.pop_back();
    const auto fitted = call(LoadWorld{fits});
    ASSERT_TRUE(fitted);
    EXPECT_EQ(fitted->applied_ns, 0) << "the first picture of the new world shows it";
    EXPECT_EQ(bus.cameras().size(), 4u);
}

// It may lag, on a busy machine; what is drawn in time must not push it on.
TEST_F(EngineTest, BySlowPolicyTheWorldNeverRunsAheadOfTheClock) {
    const auto begin = std::chrono::steady_clock::now();
    start(RunMode::realtime, OverloadPolicy::slow);
    ASSERT_TRUE(create("a", "50"));
    std::vector<stream::Subscription> subscriptions;
    const auto sink = watch("a", subscriptions);
    while (sink->units().size() < 30) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const TimeNs world_ns = call(GetWorld{})->world_ns;
    EXPECT_LE(world_ns, std::chrono::nanoseconds(std::chrono::steady_clock::now() - begin).count());
    EXPECT_GT(world_ns, 0);
}

TEST_F(EngineTest, ALongStepLetsCommandsThroughAndEndsWithTheRig) {
    start(RunMode::lockstep);
    std::promise<Result<WorldState>> promise;
    // 24 h at 100 steps/s: minutes of work.
    engine->post(
        Request<StepWorld>{{24 * 3600 * ns_per_s}, [&](auto result) { promise.set_value(std::move(result)); }});
    ASSERT_TRUE(create("a"));
    EXPECT_TRUE(call(GetWorld{}));
    EXPECT_TRUE(fetch("a"));
    auto stepped = promise.get_future();
    EXPECT_EQ(stepped.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
    engine.reset();
    EXPECT_EQ(stepped.get().error().kind, ErrorKind::unavailable);
}

TEST_F(EngineTest, AChangeWhileThePausedWorldStandsShowsAtOnceAsANewFrame) {
    start(RunMode::realtime);
    ASSERT_TRUE(create("a"));
    const TimeNs paused_ns = call(PauseWorld{})->world_ns;
    const auto before = fetch("a").value();
    SetCamera command{"a", {}};
    command.patch.size = ImageSize{320, 240};
    const auto state = call(command);
    ASSERT_TRUE(state);
    const auto after = fetch("a", state->applied_ns).value();
    EXPECT_EQ(after.info.size, (ImageSize{320, 240}));
    EXPECT_EQ(after.info.world_ns, paused_ns);
    EXPECT_GT(after.info.sequence, before.info.sequence);
}

TEST_F(EngineTest, SequenceNumbersRiseAcrossChangesOfRateAndWorld) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a"));
    std::int64_t last = fetch("a")->info.sequence;
    for (const char* fps : {"1000", "1/10", "30000/1001"}) {
        SetCamera command{"a", {}};
        command.patch.rate = Rate::parse(fps).value();
        ASSERT_TRUE(call(command));
        ASSERT_TRUE(step(10 * ns_per_s));
        const auto now = fetch("a")->info.sequence;
        EXPECT_GT(now, last) << fps;
        last = now;
    }
    auto scene = std::make_shared<world::Scene>();
    scene->name = "other";
    const auto loaded = call(LoadWorld{scene});
    ASSERT_TRUE(loaded);
    EXPECT_EQ(loaded->world_ns, 0);
    EXPECT_GT(fetch("a")->info.sequence, last);
}

TEST_F(EngineTest, TwoCamerasOfOneNameAreRefused) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a"));
    EXPECT_EQ(create("a").error().kind, ErrorKind::already_exists);
    EXPECT_EQ(call(ListCameras{})->size(), 1u);
}

TEST_F(EngineTest, CamerasAndPixelsAreBounded) {
    start(RunMode::lockstep);
    CreateCamera command;
    command.patch.size = ImageSize{8192, 8192};
    command.name = "a";
    ASSERT_TRUE(call(command));
    command.name = "b";
    ASSERT_TRUE(call(command));
    command.name = "c";
    EXPECT_EQ(call(command).error().kind, ErrorKind::resource_exhausted);
}

TEST_F(EngineTest, WaitingForAFrameThatCannotComeSaysWhy) {
    start(RunMode::realtime);
    ASSERT_TRUE(create("a", "1000"));
    const auto later = fetch("a", 30 * ns_per_ms);
    ASSERT_TRUE(later) << later.error().message;
    EXPECT_GE(later->info.world_ns, 30 * ns_per_ms);
    EXPECT_EQ(fetch("b").error().kind, ErrorKind::not_found);
}

TEST_F(EngineTest, InRealTimeStampsRiseOnTheGridAndTheBooksBalance) {
    start(RunMode::realtime);
    ASSERT_TRUE(create("a", "200"));
    std::vector<stream::Subscription> subscriptions;
    auto sink = watch("a", subscriptions);
    ASSERT_TRUE(sink->wait_for_units(50));
    const auto units = sink->units();
    for (std::size_t i = 1; i < units.size(); ++i) {
        const TimeNs world_step = units[i].info.world_ns - units[i - 1].info.world_ns;
        EXPECT_GT(world_step, 0);
        EXPECT_EQ(world_step % (5 * ns_per_ms), 0);
        EXPECT_EQ(units[i].info.monotonic_ns - units[i - 1].info.monotonic_ns, world_step);
        EXPECT_EQ(units[i].info.sequence - units[i - 1].info.sequence, world_step / (5 * ns_per_ms));
    }
    const auto report = call(GetStats{}).value();
    EXPECT_EQ(report.cameras.at(0).due, report.cameras.at(0).rendered + report.cameras.at(0).dropped);
}

TEST_F(EngineTest, PauseHoldsWorldTimeAndStepsMoveIt) {
    start(RunMode::realtime);
    ASSERT_TRUE(create("a"));
    EXPECT_FALSE(step(1));
    const auto paused = call(PauseWorld{}).value();
    EXPECT_TRUE(paused.paused);
    const auto stepped = step(ns_per_s);
    ASSERT_TRUE(stepped);
    EXPECT_EQ(stepped->world_ns, paused.world_ns + ns_per_s);
    EXPECT_FALSE(call(ResumeWorld{})->paused);
}

TEST_F(EngineTest, AReadWithoutAWishOfItsOwnShowsTheCamerasLastCommand) {
    start(RunMode::realtime);
    ASSERT_TRUE(create("a", "10"));
    for (int i = 0; i < 4; ++i) {
        SetCamera change{.name = "a", .patch = {}};
        change.patch.zoom = 1.0 + i;
        const auto changed = call(std::move(change));
        ASSERT_TRUE(changed);
        const auto picture = fetch("a");
        ASSERT_TRUE(picture) << picture.error().message;
        EXPECT_GE(picture->info.world_ns, changed->applied_ns);
        const auto earlier = fetch("a", 1);
        ASSERT_TRUE(earlier);
        EXPECT_GE(earlier->info.world_ns, picture->info.world_ns);
    }
}

/// Whoever asks bounds what is made: a picture that others had drawn is encoded and sent, too.
TEST_F(EngineTest, APictureThatIsDrawnAlreadyIsAdmittedToo) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a"));
    int asked = 0;
    const auto begin = [&](TimeNs min_ns) {
        auto promise = std::make_shared<std::promise<Result<stream::MediaUnit>>>();
        stream::FetchRequest request{.camera = "a", .min_ns = min_ns, .format = raw};
        request.admit = [&asked](ImageSize size) -> Result<void> {
            EXPECT_EQ(size, (ImageSize{160, 120}));
            ++asked;
            return error(ErrorKind::resource_exhausted, "no room");
        };
        engine->fetch(std::move(request), [promise](auto result) { promise->set_value(std::move(result)); });
        return promise->get_future();
    };
    ASSERT_TRUE(fetch("a"));  // drawn now
    const auto kept = begin(0).get();
    ASSERT_FALSE(kept);
    EXPECT_EQ(kept.error().kind, ErrorKind::resource_exhausted);
    EXPECT_EQ(asked, 1);
    std::vector<stream::Subscription> subscriptions;
    watch("a", subscriptions);
    auto for_readers = begin(200 * ns_per_ms);
    ASSERT_TRUE(step(200 * ns_per_ms));
    const auto refused = for_readers.get();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::resource_exhausted);
    EXPECT_EQ(asked, 2);
}

TEST_F(EngineTest, ShutdownAnswersWhoStillWaits) {
    start(RunMode::lockstep);
    ASSERT_TRUE(create("a"));
    std::promise<Result<stream::MediaUnit>> promise;
    engine->fetch({"a", frame::FrameKind::color, ns_per_s, raw},
                  [&](auto result) { promise.set_value(std::move(result)); });
    engine.reset();
    EXPECT_EQ(promise.get_future().get().error().kind, ErrorKind::unavailable);
}

}  // namespace
}  // namespace camrig::engine::engine_test
