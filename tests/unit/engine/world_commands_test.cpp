#include <future>

#include <gtest/gtest.h>

#include "core/base/clock.h"
#include "core/engine/engine.h"

namespace camrig::engine::world_commands_test {
namespace {

/// A world of one model without vertices, and the null renderer.
class WorldCommandsTest : public testing::Test {
protected:
    void SetUp() override {
        auto scene = std::make_shared<world::Scene>();
        scene->name = "one";
        scene->models["man"].model = std::make_shared<world::Model>();
        EngineOptions options;
        options.mode = RunMode::lockstep;
        options.renderer.device = "null";
        options.renderer.pool = pool;
        engine = Engine::start(scene, options, bus).value();
    }
    template <typename C>
    std::future<Result<typename C::Reply>> post(C command) {
        auto promise = std::make_shared<std::promise<Result<typename C::Reply>>>();
        auto reply = promise->get_future();
        engine->post(Request<C>{std::move(command), [promise](auto result) { promise->set_value(std::move(result)); }});
        return reply;
    }
    template <typename C>
    Result<typename C::Reply> call(C command) {
        return post(std::move(command)).get();
    }
    SpawnActor spawn(const std::string& name) {
        SpawnActor command;
        command.actor.name = name;
        command.actor.model = "man";
        return command;
    }

    std::shared_ptr<frame::FramePool> pool = std::make_shared<frame::FramePool>();
    stream::LocalFrameBus bus{{2, pool}};
    std::unique_ptr<Engine> engine;
};

TEST_F(WorldCommandsTest, ActAtTheWorldsLastStep) {
    ASSERT_TRUE(call(StepWorld{15 * ns_per_ms}));
    const auto spawned = call(spawn("anna"));
    ASSERT_TRUE(spawned) << spawned.error().message;
    EXPECT_EQ(spawned->applied_ns, 20 * ns_per_ms);
    const auto list = call(ListActors{});
    ASSERT_EQ(list->actors.size(), 1u);
    EXPECT_EQ(list->state.world_ns, 20 * ns_per_ms);
    const auto world = call(GetWorld{});
    EXPECT_EQ(world->actors, 1u);
    EXPECT_EQ(world->state.value, list->state.value);
    EXPECT_EQ(call(spawn("anna")).error().kind, ErrorKind::already_exists);
    ASSERT_TRUE(call(RemoveActor{"anna"}));
    EXPECT_NE(call(GetWorld{})->state.value, list->state.value);
}

TEST_F(WorldCommandsTest, AWaitingClientIsAnsweredWhenAnEventFires) {
    AddEvent add;
    add.event.name = "soon";
    add.event.when = world::AtTime{500 * ns_per_ms};
    add.event.actions = {world::UserAction{"7"}};
    ASSERT_TRUE(call(add));
    auto waiting = post(WaitEvents{0, 60 * ns_per_s});
    EXPECT_TRUE(call(WaitEvents{0, 0})->events.empty());
    ASSERT_TRUE(call(StepWorld{ns_per_s}));
    const auto log = waiting.get();
    ASSERT_TRUE(log);
    ASSERT_EQ(log->events.size(), 1u);
    EXPECT_EQ(log->events[0].sequence, 1u);
    EXPECT_EQ(log->events[0].world_ns, 500 * ns_per_ms);
    EXPECT_EQ(log->events[0].data, std::vector<std::string>{"7"});
    EXPECT_TRUE(call(WaitEvents{log->last, 10 * ns_per_ms})->events.empty());
}

TEST_F(WorldCommandsTest, AClientTooManyWaitsForEventsInPlaceOfTheOneThatWaitsLongest) {
    constexpr int most = 256;
    const TimeNs began_ns = monotonic_now_ns();
    std::vector<decltype(post(WaitEvents{}))> waiting;
    for (int i = 0; i < most; ++i) {
        waiting.push_back(post(WaitEvents{0, 60 * ns_per_s}));
        ASSERT_TRUE(call(GetWorld{}));  // it waits now
    }
    for (auto& one : waiting) EXPECT_EQ(one.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
    std::future<Result<EventLog>> one_more;
    do {  // it is refused until the first has waited for a second
        one_more = post(WaitEvents{0, 60 * ns_per_s});
        ASSERT_TRUE(call(GetWorld{}));
    } while (one_more.wait_for(std::chrono::milliseconds(20)) == std::future_status::ready);
    EXPECT_TRUE(waiting.front().get()->events.empty());
    EXPECT_GE(monotonic_now_ns() - began_ns, ns_per_s);
    EXPECT_TRUE(call(WaitEvents{0, 0})->events.empty()) << "who does not wait is answered";
    EXPECT_EQ(waiting[1].wait_for(std::chrono::seconds(0)), std::future_status::timeout);
    EXPECT_EQ(one_more.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
}

TEST_F(WorldCommandsTest, TheLogIsBoundedAndTellsWhatIsMissed) {
    AddEvent add;
    add.event.name = "often";
    add.event.when = world::EveryTime{.period_ns = 10 * ns_per_ms, .first_ns = 10 * ns_per_ms};
    ASSERT_TRUE(call(add));
    ASSERT_TRUE(call(StepWorld{20 * ns_per_s}));
    const auto log = call(WaitEvents{100, 0});
    EXPECT_EQ(log->last, 2000u);
    EXPECT_EQ(log->events.size(), 1024u);
    EXPECT_EQ(log->missed, 2000u - 100u - 1024u);
    EXPECT_EQ(log->events.back().sequence, 2000u);
}

TEST_F(WorldCommandsTest, WhatAHeadOrAFaultWillDoIsInTheDigest) {
    const auto digest = [&](double home_deg, TimeNs dwell, double probability) {
        SetUp();
        CreateCamera create;
        create.name = "c";
        create.patch.size = ImageSize{64, 48};
        create.patch.change([](world::CameraSpec& spec) { spec.ptz.emplace(); });
        EXPECT_TRUE(call(create));
        const auto go = [&](double pan_deg) {
            EXPECT_TRUE(call(MovePtz{"c", {.pan_deg = pan_deg}}));
            EXPECT_TRUE(call(StepWorld{60 * ns_per_s}));
        };
        go(home_deg);
        EXPECT_TRUE(call(PtzPresets{.camera = "c", .action = PtzPresets::Action::set_home}));
        go(0.0);
        EXPECT_TRUE(call(PtzPresets{.camera = "c", .preset = "door", .action = PtzPresets::Action::set}));
        EXPECT_TRUE(call(PtzTours{"c", "round", {{"door", dwell}}, PtzTours::Action::set}));
        EXPECT_TRUE(call(SetFault{
            "c", {.kind = fault::Drop{.probability = probability}, .begin_ns = 1000 * ns_per_s, .end_ns = {}}}));
        return call(GetDigest{})->value;
    };
    const std::uint64_t one = digest(10.0, ns_per_s, 0.5);
    EXPECT_EQ(digest(10.0, ns_per_s, 0.5), one);
    EXPECT_NE(digest(20.0, ns_per_s, 0.5), one);
    EXPECT_NE(digest(10.0, 2 * ns_per_s, 0.5), one);
    EXPECT_NE(digest(10.0, ns_per_s, 0.6), one);
}

TEST_F(WorldCommandsTest, AnEventMovesACameraFromItsInstantOn) {
    CreateCamera create;
    create.name = "c";
    create.patch.size = ImageSize{64, 48};
    ASSERT_TRUE(call(create));
    AddEvent add;
    add.event.name = "look";
    add.event.when = world::AtTime{95 * ns_per_ms};  // the step at 100 ms
    const world::CameraAction action{
        .camera = "c", .pose = camera::Pose{{1, 2, 3}}, .vfov_rad = {}, .clock = {}, .duration_ns = 0};
    add.event.actions = {action};
    ASSERT_TRUE(call(add));
    ASSERT_TRUE(call(StepWorld{80 * ns_per_ms}));
    EXPECT_EQ(call(GetCamera{"c"})->now.pose.position, glm::dvec3(0));
    ASSERT_TRUE(call(StepWorld{40 * ns_per_ms}));
    EXPECT_EQ(call(GetCamera{"c"})->now.pose.position, glm::dvec3(1, 2, 3));
}

TEST_F(WorldCommandsTest, TheFirstPictureOfAWorldShowsWhatItsEventsDidToCamerasAtItsBegin) {
    CreateCamera create;
    create.name = "stays";
    ASSERT_TRUE(call(create));
    auto scene = std::make_shared<world::Scene>();
    scene->cameras.emplace_back().name = "comes";
    world::EventSpec& look = scene->events.emplace_back();
    look.name = "look";
    look.when = world::AtTime{0};
    for (const char* camera : {"stays", "comes"})
        look.actions.push_back(world::CameraAction{
            .camera = camera, .pose = camera::Pose{{1, 2, 3}}, .vfov_rad = {}, .clock = {}, .duration_ns = 0});
    ASSERT_TRUE(call(LoadWorld{scene}));
    for (const char* camera : {"stays", "comes"}) {
        const auto truth = call(GetTruth{camera, 0});
        ASSERT_TRUE(truth) << truth.error().message;
        EXPECT_EQ((*truth)->pose.position, glm::dvec3(1, 2, 3)) << camera;
    }
}

}  // namespace
}  // namespace camrig::engine::world_commands_test
