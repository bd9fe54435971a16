#include <algorithm>
#include <future>

#include <gtest/gtest.h>

#include "core/engine/engine.h"
#include "tests/unit/stream/fake_sink.h"

// Cameras that fail, seen by their readers: a rig in lockstep with the null renderer, whose every picture is another.
namespace camrig::engine::fault_commands_test {
namespace {

class FaultCommandsTest : public testing::Test {
protected:
    void SetUp() override {
        EngineOptions options;
        options.mode = RunMode::lockstep;
        options.renderer.device = "null";
        options.renderer.pool = pool;
        engine = Engine::start(std::make_shared<world::Scene>(), options, bus).value();
        for (const char* name : {"faulty", "well"}) {
            CreateCamera create{.name = name, .place = {}, .patch = {}};
            create.patch.size = ImageSize{64, 32};
            create.patch.rate = Rate::parse("10").value();
            ASSERT_TRUE(call(std::move(create)));
        }
    }
    template <typename C>
    Result<typename C::Reply> call(C command) {
        std::promise<Result<typename C::Reply>> promise;
        engine->post(Request<C>{std::move(command), [&](auto result) { promise.set_value(std::move(result)); }});
        return promise.get_future().get();
    }
    void subscribe(const char* name, const std::shared_ptr<stream::FakeSink>& sink) {
        subscriptions.push_back(bus.subscribe(name, {}, {"test", "", {}}, sink, {}).value());
    }
    void read_both() {
        subscribe("faulty", faulty);
        subscribe("well", well);
    }
    void step(int frames) { ASSERT_TRUE(call(StepWorld{frames * 100 * ns_per_ms})); }
    std::uint64_t set(fault::FaultKind kind, double severity = 1.0) {
        SetFault command{"faulty", {.kind = std::move(kind), .begin_ns = {}, .end_ns = {}, .severity = severity}};
        return call(std::move(command)).value().fault->id;
    }
    void clear() { ASSERT_TRUE(call(ClearFaults{.id = {}, .camera = "faulty", .kind = {}})); }
    stream::CameraReport report_of(const char* name) {
        const auto cameras = call(GetStats{}).value().cameras;
        return *std::ranges::find(cameras, name, &stream::CameraReport::name);
    }
    static std::vector<std::byte> bytes_of(const stream::MediaUnit& unit) {
        return {unit.frame->bytes().begin(), unit.frame->bytes().end()};
    }

    std::shared_ptr<frame::FramePool> pool = std::make_shared<frame::FramePool>();
    stream::LocalFrameBus bus{{2, pool}};
    std::shared_ptr<stream::FakeSink> faulty = std::make_shared<stream::FakeSink>();
    std::shared_ptr<stream::FakeSink> well = std::make_shared<stream::FakeSink>();
    std::unique_ptr<Engine> engine;
    std::vector<stream::Subscription> subscriptions;
};

TEST_F(FaultCommandsTest, AFrozenCameraShowsItsFirstFrameAgainAndStampsGoOn) {
    read_both();
    step(3);
    set(fault::Freeze{});
    step(5);
    clear();
    step(2);
    const auto units = faulty->units();
    ASSERT_EQ(units.size(), 10U);
    for (std::size_t i = 0; i < units.size(); ++i) {
        EXPECT_EQ(units[i].info.sequence, static_cast<std::int64_t>(i) + 1);
        EXPECT_EQ(units[i].info.world_ns, static_cast<TimeNs>(i + 1) * 100 * ns_per_ms);
        const bool is_repeat = i >= 3 && i < 8;  // the frame of its begin is there already
        EXPECT_EQ(bytes_of(units[i]) == bytes_of(units[i - (i > 0)]), i == 0 || is_repeat) << i;
    }
    EXPECT_EQ(report_of("faulty").rendered, 10U);
}

TEST_F(FaultCommandsTest, WhatAFrozenCameraShowsDoesNotDependOnWhoReadBefore) {
    subscribe("well", well);
    step(3);
    set(fault::Freeze{});
    step(5);
    subscribe("faulty", faulty);  // nobody has seen the frozen picture
    step(2);
    ASSERT_EQ(faulty->units().size(), 2U);
    const auto late = bytes_of(faulty->units().front());
    EXPECT_EQ(late, bytes_of(faulty->units().back()));

    TearDown();
    auto first = std::make_shared<stream::FakeSink>();
    subscriptions.clear();
    engine.reset();
    SetUp();
    subscribe("faulty", first);
    step(3);
    set(fault::Freeze{});
    step(7);
    EXPECT_EQ(bytes_of(first->units().back()), late);
}

TEST_F(FaultCommandsTest, LostFramesAreMissingAndTheBooksSayWhy) {
    read_both();
    step(2);
    set(fault::Drop{.probability = 0.5, .burst_frames = 1});
    step(40);
    const auto units = faulty->units();
    const auto report = report_of("faulty");
    EXPECT_GT(units.size(), 5U);
    EXPECT_LT(units.size(), 39U);
    EXPECT_EQ(report.due, 42U);
    EXPECT_EQ(report.dropped_for[static_cast<std::size_t>(stream::DropReason::fault)], 42 - units.size());
    EXPECT_EQ(report.dropped, 42 - units.size());
    ASSERT_EQ(report.outputs.size(), 1U);
    EXPECT_EQ(report.outputs[0].due, 42U);
    EXPECT_EQ(report.outputs[0].fault, 42 - units.size());
    EXPECT_EQ(report.outputs[0].received, units.size());
    EXPECT_EQ(report_of("well").outputs[0].fault, 0U);
    EXPECT_EQ(well->units().size(), 42U);
}

TEST_F(FaultCommandsTest, LateFramesComeInOrderWithTheirOwnStampsAndAllAtOnceWhenItIsOver) {
    read_both();
    step(2);
    set(fault::Late{.frames = 3});
    step(5);
    const auto sequences = [&] {
        std::vector<std::int64_t> all;
        for (const auto& unit : faulty->units()) all.push_back(unit.info.sequence);
        return all;
    };
    auto units = faulty->units();
    const std::int64_t first = units.front().info.sequence;
    ASSERT_EQ(units.size(), 4U);  // the two before it, and of five the first two
    for (std::size_t i = 0; i < units.size(); ++i) {
        EXPECT_EQ(units[i].info.sequence, first + static_cast<std::int64_t>(i));
        EXPECT_EQ(units[i].info.world_ns, units[i].info.sequence * 100 * ns_per_ms);
    }
    clear();
    step(1);
    EXPECT_EQ(sequences(), (std::vector<std::int64_t>{first, first + 1, first + 2, first + 3, first + 4, first + 5,
                                                      first + 6, first + 7}));
    EXPECT_EQ(well->units().size(), 8U);
    const auto books = report_of("faulty").outputs[0];
    EXPECT_EQ(books.due, books.received + books.fault + books.not_drawn);
    EXPECT_EQ(books.readers[0].offered, books.readers[0].delivered + books.readers[0].dropped);
}

TEST_F(FaultCommandsTest, LateFramesThatWaitAreDroppedWithTheirReader) {
    read_both();
    set(fault::Late{.frames = 5});
    step(4);
    EXPECT_TRUE(faulty->units().empty());
    subscriptions.clear();
    step(1);
}

TEST_F(FaultCommandsTest, ATornPictureIsOfTwoFrames) {
    read_both();
    step(3);
    const auto before = bytes_of(faulty->units().back());
    set(fault::Tearing{.share = 0.25});
    step(1);
    const auto torn = bytes_of(faulty->units().back());
    clear();
    ASSERT_EQ(torn.size(), before.size());
    const auto cut = static_cast<std::ptrdiff_t>(torn.size() * 3 / 4);
    EXPECT_EQ(std::vector(torn.begin() + cut, torn.end()), std::vector(before.begin() + cut, before.end()));
    EXPECT_NE(std::vector(torn.begin(), torn.begin() + cut), std::vector(before.begin(), before.begin() + cut));
    step(1);
    const auto own = bytes_of(faulty->units().back());
    set(fault::Tearing{.share = 1.0});
    step(1);
    EXPECT_EQ(bytes_of(faulty->units().back()), own);
}

TEST_F(FaultCommandsTest, ABlackCameraIsNotDrawn) {
    read_both();
    step(1);
    const auto drawn_before = faulty->units().size();
    set(fault::Black{});
    step(3);
    const auto units = faulty->units();
    ASSERT_EQ(units.size(), drawn_before + 3);
    for (std::size_t i = drawn_before; i < units.size(); ++i) {
        const auto bytes = bytes_of(units[i]);
        for (std::size_t b = 0; b < bytes.size(); ++b) ASSERT_EQ(bytes[b], std::byte(b % 4 == 3 ? 255 : 0));
    }
}

TEST_F(FaultCommandsTest, PixelsOfWhatIsDrawnAreChangedForReadersAndOnRequest) {
    read_both();
    step(1);
    set(fault::Black{}, 0.5);
    step(2);
    const auto is_half_black = [](std::span<const std::byte> bytes) {
        return std::ranges::all_of(bytes.subspan(0, 3), [](std::byte value) { return value <= std::byte{128}; }) &&
               bytes[3] == std::byte{255};
    };
    const auto units = faulty->units();
    ASSERT_EQ(units.size(), 3U);
    bool was_bright = false;
    for (const std::byte value : bytes_of(units[0])) was_bright |= value > std::byte{128} && value < std::byte{255};
    EXPECT_TRUE(was_bright);
    for (std::size_t i = 1; i < 3; ++i) {
        const auto bytes = bytes_of(units[i]);
        for (std::size_t at = 0; at < bytes.size(); at += 4)
            ASSERT_TRUE(is_half_black(std::span(bytes).subspan(at, 4)));
    }
    std::promise<Result<stream::MediaUnit>> asked;
    engine->fetch({"faulty", frame::FrameKind::color, 0, {}}, [&](auto unit) { asked.set_value(std::move(unit)); });
    EXPECT_EQ(bytes_of(asked.get_future().get().value()), bytes_of(units.back()));
}

TEST_F(FaultCommandsTest, OtherCamerasGetTheSameBytes) {
    read_both();
    step(10);
    std::vector<std::vector<std::byte>> alone;
    for (const auto& unit : well->units()) alone.push_back(bytes_of(unit));

    subscriptions.clear();
    engine.reset();
    faulty = std::make_shared<stream::FakeSink>();
    well = std::make_shared<stream::FakeSink>();
    SetUp();
    read_both();
    for (auto kind : std::vector<fault::FaultKind>{fault::Freeze{}, fault::Drop{}, fault::Black{}, fault::Duplicate{}})
        set(kind, 0.6);
    step(10);
    const auto units = well->units();
    ASSERT_EQ(units.size(), alone.size());
    for (std::size_t i = 0; i < units.size(); ++i) EXPECT_EQ(bytes_of(units[i]), alone[i]) << i;
}

TEST_F(FaultCommandsTest, TruthIsOfTheInstantAndTellsTheFault) {
    step(2);
    const auto id = set(fault::Freeze{});
    step(3);
    const auto truth = call(GetTruth{"faulty", 0}).value();
    EXPECT_EQ(truth->sequence, 5);
    EXPECT_EQ(truth->world_ns, 500 * ns_per_ms);
    ASSERT_TRUE(truth->faults);
    ASSERT_EQ(truth->faults->active.size(), 1U);
    EXPECT_EQ(truth->faults->active[0]->id, id);
    EXPECT_EQ(truth->faults->shown_sequence, 2);
    EXPECT_FALSE(call(GetTruth{"well", 0}).value()->faults);
}

TEST_F(FaultCommandsTest, EventsSetAndClearFaults) {
    read_both();
    AddEvent add;
    add.event.name = "night";
    add.event.when = world::AtTime{250 * ns_per_ms};
    add.event.actions = {world::FaultAction{"faulty", {.kind = fault::Black{}, .begin_ns = {}, .end_ns = {}}, {}}};
    ASSERT_TRUE(call(add));
    add.event.name = "day";
    add.event.when = world::AtTime{650 * ns_per_ms};
    add.event.actions = {world::ClearFaultAction{"faulty", "black"}};
    ASSERT_TRUE(call(add));
    step(9);
    const auto units = faulty->units();
    ASSERT_EQ(units.size(), 9U);
    for (const auto& unit : units) {
        const bool is_black =
            bytes_of(unit)[0] == std::byte{0} && bytes_of(unit)[1] == std::byte{0} && bytes_of(unit)[2] == std::byte{0};
        EXPECT_EQ(is_black, unit.info.sequence >= 3 && unit.info.sequence <= 6) << unit.info.sequence;
    }
    EXPECT_TRUE(call(ListFaults{.camera = {}})->faults.empty());
}

TEST_F(FaultCommandsTest, FaultsAreListedAndClearedByTheirNumber) {
    const auto first = set(fault::Black{}), second = set(fault::Freeze{});
    EXPECT_NE(first, second);
    EXPECT_EQ(call(ListFaults{.camera = "faulty"})->faults.size(), 2U);
    EXPECT_TRUE(call(ListFaults{.camera = "well"})->faults.empty());
    EXPECT_EQ(call(ClearFaults{.id = first, .camera = {}, .kind = {}})->cleared, 1U);
    ASSERT_EQ(call(ListFaults{.camera = {}})->faults.size(), 1U);
    EXPECT_EQ(call(ListFaults{.camera = {}})->faults[0].fault->id, second);
    EXPECT_EQ(call(ClearFaults{.id = first, .camera = {}, .kind = {}}).error().kind, ErrorKind::not_found);
    EXPECT_EQ(call(SetFault{"nobody", {}}).error().kind, ErrorKind::not_found);
}

}  // namespace
}  // namespace camrig::engine::fault_commands_test
