#include <atomic>
#include <future>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include "core/stream/local_frame_bus.h"
#include "tests/unit/stream/fake_sink.h"

namespace camrig::stream {
namespace {

constexpr CameraId lobby{1};
constexpr MediaFormat jpeg{codec::Codec::jpeg, frame::PixelFormat::rgba8, 90, {}};
constexpr MediaFormat raw{};
/// Made before any thread is: spdlog itself is not built for the thread sanitizer, which does not see its guard.
const auto logger = spdlog::default_logger();

class FrameBusTest : public testing::Test {
protected:
    FrameBusTest() { bus.add_camera({lobby, "lobby", {64, 48}, Rate::create(25, 1).value()}); }

    frame::FrameSet set_at(TimeNs world_ns, std::int64_t sequence) {
        frame::FrameInfo info;
        info.camera_id = lobby;
        info.camera = name;
        info.sequence = sequence;
        info.world_ns = world_ns;
        info.size = {64, 48};
        auto frame = pool->acquire(info);
        std::ranges::fill(frame->mutable_bytes(), std::byte{static_cast<unsigned char>(sequence * 10)});
        frame::FrameSet set;
        set.world_ns = world_ns;
        set.frames.push_back(frame);
        return set;
    }
    Subscription subscribe(std::shared_ptr<FakeSink> sink, const MediaFormat& format = raw,
                           std::optional<Rate> rate = {}, std::function<void(Error)> on_end = {}) {
        auto subscription = bus.subscribe("lobby", format, {"test", "me", rate}, std::move(sink), std::move(on_end));
        EXPECT_TRUE(subscription);
        return std::move(*subscription);
    }

    std::shared_ptr<const std::string> name = std::make_shared<const std::string>("lobby");
    std::shared_ptr<frame::FramePool> pool = std::make_shared<frame::FramePool>();
    LocalFrameBus bus{{2, pool}};
};

TEST_F(FrameBusTest, NobodyWatchingMeansNothingIsWanted) {
    EXPECT_TRUE(bus.wanted(lobby, 0).empty());
    auto sink = std::make_shared<FakeSink>();
    auto subscription = subscribe(sink);
    EXPECT_FALSE(bus.wanted(lobby, 0).empty());
    subscription.reset();
    EXPECT_TRUE(bus.wanted(lobby, 0).empty());
    EXPECT_EQ(bus.reader_count(lobby), 0u);
}

// One encode per (camera, codec, quality), whoever reads.
TEST_F(FrameBusTest, ReadersOfOneFormatShareOneEncoding) {
    auto first = std::make_shared<FakeSink>(), second = std::make_shared<FakeSink>(),
         other = std::make_shared<FakeSink>();
    auto s1 = subscribe(first, jpeg), s2 = subscribe(second, jpeg);
    auto s3 = subscribe(other, {codec::Codec::jpeg, frame::PixelFormat::rgba8, 50, {}});
    bus.publish(set_at(0, 1), nullptr);
    ASSERT_TRUE(first->wait_for_units(1) && second->wait_for_units(1) && other->wait_for_units(1));
    EXPECT_EQ(first->units()[0].bytes, second->units()[0].bytes);
    EXPECT_NE(first->units()[0].bytes, other->units()[0].bytes);
}

// A renderer that makes the layouts of the readers spares their conversion.
TEST_F(FrameBusTest, EachOutputGetsTheLayoutItWantsElseRgba) {
    const auto i420 = std::make_shared<FakeSink>(), half = std::make_shared<FakeSink>(),
               plain = std::make_shared<FakeSink>();
    auto s1 = subscribe(i420, {codec::Codec::raw, frame::PixelFormat::i420, 0, {}});
    auto s2 = subscribe(half, {codec::Codec::raw, frame::PixelFormat::i420, 0, {32, 24}});
    EXPECT_EQ(bus.wanted(lobby, 0), (frame::PixelFormats{frame::PixelFormat::i420, frame::PixelFormat::rgba8}));
    frame::FrameSet set = set_at(0, 1);
    frame::FrameInfo info = set.frames[0]->info();
    info.format = frame::PixelFormat::i420;
    auto planes = pool->acquire(info);
    std::ranges::fill(planes->mutable_bytes(), std::byte{200});
    set.frames.push_back(planes);
    bus.publish(set, nullptr);
    ASSERT_TRUE(i420->wait_for_units(1) && half->wait_for_units(1));
    EXPECT_EQ(i420->units()[0].frame, planes);
    EXPECT_EQ(half->units()[0].info.size, (ImageSize{32, 24}));
    EXPECT_NE(half->units()[0].frame->bytes()[0], std::byte{200});

    // One that came after the picture was drawn waits for the next.
    auto s3 = subscribe(plain);
    frame::FrameSet only_planes;
    info.sequence = 2;
    only_planes.frames.push_back(pool->acquire(info));
    bus.publish(only_planes, nullptr);
    ASSERT_TRUE(i420->wait_for_units(2));
    EXPECT_EQ(plain->units().size(), 0u);
    EXPECT_EQ(half->units().size(), 1u);
    bus.publish(set_at(2, 3), nullptr);
    ASSERT_TRUE(plain->wait_for_units(1) && i420->wait_for_units(3));
    EXPECT_EQ(i420->units()[2].info.format, frame::PixelFormat::i420);
}

TEST(SourceFormat, IsWhatNeedsNoConversion) {
    constexpr ImageSize own{64, 48};
    EXPECT_EQ(source_format({codec::Codec::jpeg, frame::PixelFormat::rgba8, 90, {}}, own),
              frame::PixelFormat::jpeg_i420);
    EXPECT_EQ(
        source_format({codec::Codec::jpeg, frame::PixelFormat::rgba8, 90, {}, codec::ChromaSampling::yuv422}, own),
        frame::PixelFormat::rgba8);
    EXPECT_EQ(source_format({codec::Codec::raw, frame::PixelFormat::yuyv, 0, {}}, own), frame::PixelFormat::yuyv);
    EXPECT_EQ(source_format({codec::Codec::raw, frame::PixelFormat::yuyv, 0, own}, own), frame::PixelFormat::yuyv);
    EXPECT_EQ(source_format({codec::Codec::raw, frame::PixelFormat::yuyv, 0, {32, 24}}, own),
              frame::PixelFormat::rgba8);
    EXPECT_EQ(source_format({codec::Codec::png, frame::PixelFormat::rgba8, 0, {}}, own), frame::PixelFormat::rgba8);
}

// A stuck consumer must cost frames, never time.
TEST_F(FrameBusTest, SlowOutputGetsNewestFrameAndCountsTheRest) {
    auto slow = std::make_shared<FakeSink>(), quick = std::make_shared<FakeSink>();
    slow->set_stuck(true);
    auto s1 = subscribe(slow, raw), s2 = subscribe(quick, jpeg);
    bus.publish(set_at(0, 1), nullptr);
    ASSERT_TRUE(quick->wait_for_units(1));
    for (int i = 2; i <= 10; ++i) bus.publish(set_at(i, i), nullptr);
    slow->set_stuck(false);
    // The first may have been replaced before the worker took it; the newest always arrives.
    ASSERT_TRUE(slow->wait_for_units(1));
    for (auto units = slow->units(); units.back().info.sequence != 10; units = slow->units())
        ASSERT_TRUE(slow->wait_for_units(units.size() + 1));
    const auto stats = slow->info().stats;
    EXPECT_EQ(stats->offered.load(), 10u);
    EXPECT_EQ(stats->offered.load(), stats->delivered.load() + stats->dropped.load());
}

TEST_F(FrameBusTest, AReaderCanTakeALowerRateThanTheCamera) {
    auto sink = std::make_shared<FakeSink>();
    auto subscription = subscribe(sink, raw, Rate::create(10, 1).value());
    const Rate rate = Rate::create(25, 1).value();
    int wanted = 0;
    for (int n = 0; n < 50; ++n) {
        const TimeNs t = rate.time_of_frame(n);
        if (bus.wanted(lobby, t).empty()) continue;
        bus.publish(set_at(t, n), nullptr);
        ASSERT_TRUE(sink->wait_for_units(static_cast<std::size_t>(++wanted)));
    }
    EXPECT_EQ(wanted, 20);
}

TEST_F(FrameBusTest, OfFramesThatDoNotComeAReaderMissesThoseThatItWouldHaveTaken) {
    const auto all = std::make_shared<FakeSink>(), few = std::make_shared<FakeSink>();
    auto slow = subscribe(few, raw, Rate::create(1, 1).value());
    const Rate rate = Rate::create(30, 1).value();
    const auto miss = [&](std::int64_t first, std::int64_t last) {
        return bus.miss(
            lobby, {rate.time_of_frame(first), rate.time_of_frame(last), static_cast<std::uint64_t>(last - first + 1)},
            DropReason::overload);
    };
    EXPECT_EQ(miss(1, 29), 1u) << "it has had none yet";
    bus.publish(set_at(rate.time_of_frame(30), 30), nullptr);
    ASSERT_TRUE(few->wait_for_units(1));
    EXPECT_EQ(miss(31, 59), 0u);
    EXPECT_EQ(miss(60, 149), 3u);
    auto fast = subscribe(all);
    EXPECT_EQ(miss(150, 179), 30u) << "as many as the reader that takes most";
    slow.reset();
    fast.reset();
    EXPECT_EQ(miss(180, 209), 0u);
}

TEST_F(FrameBusTest, DeletingTheCameraEndsItsReadersAndSaysWhy) {
    auto sink = std::make_shared<FakeSink>();
    std::promise<Error> ended;
    auto subscription = subscribe(sink, raw, {}, [&](Error why) { ended.set_value(std::move(why)); });
    bus.publish(set_at(0, 1), nullptr);
    ASSERT_TRUE(sink->wait_for_units(1));
    bus.remove_camera(lobby);
    const Error why = ended.get_future().get();
    EXPECT_EQ(why.message, "camera lobby was deleted");
    EXPECT_EQ(sink->closed(), 1);
    subscription.reset();
    EXPECT_EQ(sink->closed(), 1);
    EXPECT_FALSE(bus.find("lobby"));
}

TEST_F(FrameBusTest, AChangeOfSizeEndsReadersAChangeOfRateDoesNot) {
    auto sink = std::make_shared<FakeSink>();
    auto subscription = subscribe(sink);
    bus.publish(set_at(0, 1), nullptr);
    ASSERT_TRUE(sink->wait_for_units(1));
    bus.change_camera({lobby, "lobby", {64, 48}, Rate::create(5, 1).value()});
    EXPECT_EQ(bus.reader_count(lobby), 1u);
    bus.change_camera({lobby, "lobby", {128, 48}, Rate::create(5, 1).value()});
    EXPECT_TRUE(sink->wait_for_close());
    EXPECT_EQ(bus.reader_count(lobby), 0u);
}

TEST_F(FrameBusTest, AnUnavailableSinkIsKeptAndAFailingOneEnds) {
    auto sink = std::make_shared<FakeSink>(), second = std::make_shared<FakeSink>();
    sink->fail_open(Error{ErrorKind::unavailable, "no device"});
    auto s1 = subscribe(sink, raw);
    std::promise<Error> ended;
    auto s2 = subscribe(second, jpeg, {}, [&](Error why) { ended.set_value(std::move(why)); });
    second->fail_writes(Error{ErrorKind::internal, "broken"});
    bus.publish(set_at(0, 1), nullptr);
    EXPECT_EQ(ended.get_future().get().message, "broken");
    EXPECT_EQ(bus.reader_count(lobby), 1u);
}

TEST_F(FrameBusTest, WhoDetachedBeforeItsWriteFailedHearsOfNoEnd) {
    auto sink = std::make_shared<FakeSink>();
    std::atomic<int> ends = 0;
    {
        LocalFrameBus own{{1, pool}};
        own.add_camera({lobby, "lobby", {64, 48}, Rate::create(25, 1).value()});
        auto subscription = own.subscribe("lobby", raw, {"test", "me", {}}, sink, [&](Error) { ++ends; }).value();
        sink->set_stuck(true);
        sink->fail_writes(Error{ErrorKind::internal, "broken"});
        own.publish(set_at(0, 1), nullptr);
        ASSERT_TRUE(sink->wait_for_write());
        std::jthread leaving([&] { subscription.reset(); });
        while (own.reader_count(lobby) != 0) std::this_thread::yield();
        sink->set_stuck(false);
    }
    EXPECT_EQ(ends, 0);
    EXPECT_EQ(sink->closed(), 1);
}

TEST_F(FrameBusTest, TheLatchOpensWhenTheLastReaderHasItsFrame) {
    auto sink = std::make_shared<FakeSink>();
    sink->keep_holds();
    auto subscription = subscribe(sink);
    std::promise<void> opened;
    auto latch = DeliveryLatch::create([&] { opened.set_value(); });
    bus.publish(set_at(0, 1), latch);
    ASSERT_TRUE(sink->wait_for_units(1));
    EXPECT_FALSE(latch->is_open());
    while (latch->holders().size() > 1) std::this_thread::yield();  // the encoding's own hold goes a moment later
    EXPECT_THAT(latch->holders(), testing::ElementsAre("fake reader"));
    sink->release_holds();
    opened.get_future().wait();
    EXPECT_TRUE(latch->is_open());
}

TEST_F(FrameBusTest, APictureThatNoWorkerTakesIsAnError) {
    LocalFrameBus busy{{.workers = 1, .pool = pool, .max_jobs = 0}};
    std::optional<Result<MediaUnit>> answer;
    busy.transcode_once(set_at(0, 1).frames.front(), raw, [&](Result<MediaUnit> unit) { answer = std::move(unit); });
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->error().kind, ErrorKind::resource_exhausted);
}

// An output whose turn was refused would hold its frame, and a step that waits for it, for ever.
TEST_F(FrameBusTest, OutputsHaveTheirTurnHoweverManyPicturesWait) {
    LocalFrameBus busy{{.workers = 1, .pool = pool, .max_jobs = 0}};
    busy.add_camera({lobby, "lobby", {64, 48}, Rate::create(25, 1).value()});
    auto sink = std::make_shared<FakeSink>();
    std::promise<void> opened, ended;
    auto subscription =
        busy.subscribe("lobby", raw, {"test", "me", {}}, sink, [&](const Error&) { ended.set_value(); });
    busy.publish(set_at(0, 1), DeliveryLatch::create([&] { opened.set_value(); }));
    EXPECT_EQ(opened.get_future().wait_for(std::chrono::seconds(20)), std::future_status::ready);
    EXPECT_TRUE(sink->wait_for_units(1));
    busy.remove_camera(lobby);
    EXPECT_EQ(ended.get_future().wait_for(std::chrono::seconds(20)), std::future_status::ready);
}

TEST_F(FrameBusTest, FormatsAndReadersAreBounded) {
    std::vector<Subscription> all;
    Result<Subscription> last = error(ErrorKind::internal, "");
    for (int quality = 1; quality <= 30; ++quality) {
        last = bus.subscribe("lobby", {codec::Codec::jpeg, frame::PixelFormat::rgba8, quality, {}}, {"test", "me", {}},
                             std::make_shared<FakeSink>(), {});
        if (!last) break;
        all.push_back(std::move(*last));
    }
    EXPECT_EQ(all.size(), LocalFrameBus::max_outputs_per_camera);
    EXPECT_EQ(last.error().kind, ErrorKind::resource_exhausted);
    EXPECT_EQ(bus.subscribe("nowhere", raw, {}, std::make_shared<FakeSink>(), {}).error().message,
              "no camera 'nowhere'; there are: lobby");
}

}  // namespace
}  // namespace camrig::stream
