#include <gmock/gmock.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "tests/unit/v4l2_sink/loopback/fake_bus.h"
#include "tests/unit/v4l2_sink/loopback/fake_module.h"
#include "v4l2_sink/loopback/loopback_host.h"

namespace camrig::device {
namespace {

using testing::HasSubstr;
using testing::Not;

LoopbackSettings settings(int width = 64, int height = 48, const char* camera = "lobby", int rate = 25) {
    return {video_number, camera, {V4L2_PIX_FMT_YUYV, {width, height}, *Rate::create(rate, 1)}};
}

/// A host on a module of some generation, with a clock that the test moves.
class HostFixture {
public:
    explicit HostFixture(int minor, LoopbackHost::Options options = {}) : kernel(minor), options_(options) {
        if (minor == 12) kernel.plug(video_number, "lobby");
        spdlog::set_default_logger(
            std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log_)));
        start();
    }
    ~HostFixture() { spdlog::set_default_logger(before_); }

    void start() { host = std::make_unique<LoopbackHost>(bus, bus, kernel, tasks, options_); }
    void tick(TimeNs later_ns = 250 * ns_per_ms) {
        now_ns += later_ns;
        tasks->run();
        host->tick(now_ns);
    }
    /// A device that has its first picture.
    void set_up(const LoopbackSettings& what = settings()) {
        host->set(what, now_ns);
        tick();
        bus.answer_fetches(++sequence, now_ns, std::byte{1});
        tick();
    }
    FakeModule::Device& device() { return kernel.devices.at(video_number); }
    std::string take_log() {
        std::string text = log_.str();
        log_.str("");
        return text;
    }

    FakeBus bus;
    FakeModule kernel;
    std::shared_ptr<TaskQueue> tasks = std::make_shared<TaskQueue>();
    std::unique_ptr<LoopbackHost> host;
    TimeNs now_ns = monotonic_now_ns();
    std::int64_t sequence = 0;

private:
    const LoopbackHost::Options options_;
    std::ostringstream log_;
    const std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
};

class LoopbackHostOf : public testing::TestWithParam<int>, public HostFixture {
protected:
    LoopbackHostOf() : HostFixture(GetParam()) {}
    bool tells() const { return GetParam() >= 13; }
};
INSTANTIATE_TEST_SUITE_P(Generations, LoopbackHostOf, testing::Values(12, 13, 14, 15));

TEST_P(LoopbackHostOf, ADeviceIsACameraAsSoonAsItHasAPicture) {
    host->set(settings(), now_ns);
    tick();
    ASSERT_TRUE(kernel.devices.contains(video_number));
    EXPECT_EQ(device().card, "lobby");
    EXPECT_FALSE(device().keep_format);
    bus.answer_fetches(1, now_ns, std::byte{1});
    tick();
    EXPECT_TRUE(device().keep_format);
    EXPECT_EQ(device().pictures.size(), 1u);
}

TEST_P(LoopbackHostOf, ACameraIsDrawnWhileSomebodyReads) {
    set_up();
    EXPECT_EQ(bus.subscribers().size(), tells() ? 0u : 1u);
    kernel.reader_comes(video_number);
    tick(0);
    ASSERT_EQ(bus.subscribers().size(), 1u);
    EXPECT_EQ(bus.subscribers()[0]->camera, "lobby");
    ASSERT_TRUE(bus.publish(++sequence, now_ns, std::byte{2}));
    EXPECT_EQ(device().pictures.back().bytes[0], std::byte{2});
    kernel.reader_leaves(video_number);
    tick(0);
    EXPECT_EQ(bus.subscribers().size(), tells() ? 0u : 1u);
}

TEST_P(LoopbackHostOf, TheNextReadersFirstPictureIsNotOld) {
    set_up();
    for (int i = 0; i < 8; ++i) {
        tick();
        bus.answer_fetches(++sequence, now_ns, std::byte{9});
    }
    tick();
    if (tells()) {
        EXPECT_GE(bus.fetches, 2);
        EXPECT_EQ(device().pictures.back().bytes[0], std::byte{9});
    } else {
        EXPECT_EQ(bus.fetches, 1);  // always subscribed
    }
}

TEST_P(LoopbackHostOf, DeletionRemovesTheDeviceOrFreesIt) {
    set_up();
    host->unset(video_number, now_ns);
    tick();
    EXPECT_TRUE(bus.subscribers().empty());
    EXPECT_EQ(kernel.open_descriptors(), 0u);
    if (tells()) {
        EXPECT_FALSE(kernel.devices.contains(video_number));
    } else {
        EXPECT_FALSE(device().keep_format);
        EXPECT_FALSE(device().has_format);
    }
    EXPECT_TRUE(host->is_idle());
}

TEST_P(LoopbackHostOf, ADeviceThatIsReadIsRemovedWhenItsReaderGoes) {
    set_up();
    kernel.reader_comes(video_number);
    host->unset(video_number, now_ns);
    tick();
    EXPECT_TRUE(kernel.devices.contains(video_number));
    kernel.reader_leaves(video_number);
    tick(2 * ns_per_s);
    EXPECT_EQ(kernel.devices.contains(video_number), !tells());
}

TEST_P(LoopbackHostOf, ADeviceThatTheUserMadeIsNotRemoved) {
    kernel.plug(video_number, "by hand");
    set_up();
    host->unset(video_number, now_ns);
    tick();
    EXPECT_TRUE(kernel.devices.contains(video_number));
    EXPECT_FALSE(device().keep_format);
}

// A user may well give it the camera's name (modprobe ... card_label=lobby).
TEST_P(LoopbackHostOf, ADeviceOfTheCamerasNameThatTheUserMadeStaysToo) {
    kernel.plug(video_number, "lobby");
    set_up();
    host->unset(video_number, now_ns);
    tick();
    EXPECT_TRUE(kernel.devices.contains(video_number));
    set_up();
    host.reset();
    EXPECT_TRUE(kernel.devices.contains(video_number));
    EXPECT_EQ(kernel.removed, 0);
}

TEST_P(LoopbackHostOf, AfterAKillTheSameDeviceServesTheWaitingReader) {
    set_up();
    kernel.reader_comes(video_number);
    tick();
    static auto& killed = *new std::vector<LoopbackHost*>;  // nothing of it runs any more, not even a destructor
    killed.push_back(host.release());
    kernel.close_all();
    start();
    const std::size_t before = device().pictures.size();
    host->set(settings(), now_ns);
    tick();
    tick();
    ASSERT_EQ(bus.subscribers().size(), 2u);  // the dead one's too
    stream::StreamInfo info;
    info.stats = std::make_shared<stream::ReaderStats>();
    ASSERT_TRUE(bus.subscribers()[1]->sink->open(info));
    ASSERT_TRUE(
        bus.subscribers()[1]->sink->write(FakeBus::unit(bus.subscribers()[1]->format, 1, now_ns, std::byte{3})));
    EXPECT_EQ(device().pictures.size(), before + 1);
    EXPECT_EQ(device().pictures.back().bytes[0], std::byte{3});
    EXPECT_EQ(kernel.added, tells() ? 1 : 0);
    host.reset();
    EXPECT_TRUE(kernel.devices.contains(video_number));  // it is being read
}

TEST_P(LoopbackHostOf, AnEndingRigTakesItsDevicesAlong) {
    set_up();
    host.reset();
    EXPECT_EQ(kernel.devices.contains(video_number), !tells());
    EXPECT_EQ(kernel.open_descriptors(), 0u);
}

TEST_P(LoopbackHostOf, AChangedSizeReachesADeviceThatNobodyReads) {
    set_up();
    bus.end_all({ErrorKind::unavailable, "the size changed"});
    host->set(settings(32, 32), now_ns);
    tick();
    EXPECT_EQ(device().pix.width, 32u);
    bus.answer_fetches(++sequence, now_ns, std::byte{4});
    tick();
    EXPECT_EQ(device().pictures.back().bytes.size(), 32u * 32 * 2);
}

TEST_P(LoopbackHostOf, AChangedSizeWaitsForTheReaderWhoseStreamGoesOn) {
    set_up();
    kernel.reader_comes(video_number);
    tick();
    take_log();
    bus.end_all({ErrorKind::unavailable, "the size changed"});
    host->set(settings(32, 32), now_ns);
    tick();
    tick();
    EXPECT_EQ(device().pix.width, 64u);
    ASSERT_EQ(bus.subscribers().size(), 1u);
    EXPECT_EQ(bus.subscribers()[0]->format.size, (ImageSize{64, 48}));
    const std::string log = take_log();
    EXPECT_THAT(log, HasSubstr("a program has it open at YUYV 64x48"));
    EXPECT_THAT(log, HasSubstr("YUYV 32x32 when that program closes it"));
    for (int i = 0; i < 30; ++i) tick();
    EXPECT_THAT(take_log(), Not(HasSubstr("a program has it open")));  // said once

    kernel.reader_leaves(video_number);
    tick(tells() ? 0 : 5 * ns_per_s);
    EXPECT_EQ(device().pix.width, 32u);
}

TEST_P(LoopbackHostOf, AChangedRateIsToldWithoutDisturbingTheReader) {
    set_up();
    kernel.reader_comes(video_number);
    tick();
    host->set(settings(64, 48, "lobby", 10), now_ns);
    tick();
    EXPECT_EQ(device().interval.denominator, 10u);
    EXPECT_EQ(bus.subscribers().size(), 1u);
}

TEST_P(LoopbackHostOf, MjpgHasTheSubsamplingThatIsSet) {
    LoopbackSettings mjpg = settings();
    mjpg.format.fourcc = V4L2_PIX_FMT_MJPEG;
    set_up(mjpg);
    kernel.reader_comes(video_number);
    tick();
    ASSERT_EQ(bus.subscribers().size(), 1u);
    EXPECT_EQ(bus.subscribers()[0]->format.sampling, codec::ChromaSampling::yuv422);
    mjpg.format.mjpg_sampling = codec::ChromaSampling::yuv420;
    host->set(mjpg, now_ns);
    tick();
    ASSERT_EQ(bus.subscribers().size(), 1u);
    EXPECT_EQ(bus.subscribers()[0]->format.sampling, codec::ChromaSampling::yuv420);
}

TEST_P(LoopbackHostOf, AReadersRateIsNoticedAndPutBack) {
    set_up();
    device().interval = {1, 30};
    tick(ns_per_s);
    EXPECT_EQ(device().interval.denominator, 25u);
    EXPECT_THAT(take_log(), HasSubstr("asked for another rate; it stays 25"));
}

TEST_P(LoopbackHostOf, ASilentCameraKeepsItsReaderAlive) {
    set_up();
    kernel.reader_comes(video_number);
    for (int i = 0; i < 40; ++i) tick();
    EXPECT_GE(device().pictures.size(), 6u);
}

// A step of a world that is paused in real time has a latch too.
TEST_P(LoopbackHostOf, APausedWorldsReaderIsKeptAliveAfterAStepToo) {
    set_up();
    kernel.reader_comes(video_number);
    tick();
    ASSERT_TRUE(bus.publish(++sequence, now_ns, std::byte{2}, stream::DeliveryLatch::create()));
    const std::size_t shown = device().pictures.size();
    for (int i = 0; i < 40; ++i) tick();
    EXPECT_GE(device().pictures.size(), shown + 5);
}

TEST_P(LoopbackHostOf, AWriteThatFailsOpensTheDeviceAnew) {
    set_up();
    kernel.reader_comes(video_number);
    tick();
    kernel.write_problem = EIO;
    EXPECT_FALSE(bus.publish(++sequence, now_ns, std::byte{2}));
    tick();
    EXPECT_THAT(take_log(), HasSubstr("Input/output error"));
    kernel.write_problem = 0;
    tick(2 * ns_per_s);
    ASSERT_TRUE(bus.publish(++sequence, now_ns, std::byte{5}));
    EXPECT_EQ(device().pictures.back().bytes[0], std::byte{5});
}

TEST_P(LoopbackHostOf, AThousandCamerasComeAndGo) {
    for (int i = 0; i < 1000; ++i) {
        set_up();
        host->unset(video_number, now_ns);
        tick();
    }
    EXPECT_EQ(kernel.added, tells() ? 1000 : 0);
    EXPECT_EQ(kernel.removed, tells() ? 1000 : 0);
    EXPECT_EQ(kernel.open_descriptors(), 0u);
    EXPECT_TRUE(bus.subscribers().empty());
}

TEST(LoopbackHost, AMissingModuleIsToldOnceAndUsedWhenItComes) {
    HostFixture fixture(15);
    fixture.kernel.loaded = false;
    fixture.host->set(settings(), fixture.now_ns);
    for (int i = 0; i < 20; ++i) fixture.tick();
    const std::string log = fixture.take_log();
    EXPECT_THAT(log, HasSubstr("camera lobby"));
    EXPECT_THAT(log, HasSubstr("modprobe v4l2loopback"));
    EXPECT_EQ(std::ranges::count(log, '\n'), 1);
    fixture.kernel.loaded = true;
    fixture.tick(ns_per_s);
    EXPECT_TRUE(fixture.kernel.devices.contains(video_number));
}

TEST(LoopbackHost, ANewNodeMayGetItsGroupAMomentLater) {
    HostFixture fixture(15);
    fixture.kernel.open_problem = EACCES;
    fixture.host->set(settings(), fixture.now_ns);
    fixture.tick();
    fixture.tick();
    EXPECT_EQ(fixture.take_log(), "");
    fixture.kernel.open_problem = 0;
    fixture.tick();
    EXPECT_THAT(fixture.take_log(), HasSubstr("/dev/video10 shows YUYV 64x48"));
}

TEST(LoopbackHost, MissingPermissionIsToldInTheEnd) {
    HostFixture fixture(15);
    fixture.kernel.open_problem = EACCES;
    fixture.host->set(settings(), fixture.now_ns);
    for (int i = 0; i < 20; ++i) fixture.tick();
    EXPECT_THAT(fixture.take_log(), HasSubstr("usermod -aG video"));
}

TEST(LoopbackHost, AnotherCameraOnTheNumberGetsADeviceOfItsName) {
    HostFixture fixture(15);
    fixture.set_up();
    fixture.host->set(settings(64, 48, "gallery"), fixture.now_ns);
    fixture.tick();
    EXPECT_EQ(fixture.device().card, "gallery");
    EXPECT_EQ(fixture.kernel.removed, 1);
}

TEST(LoopbackHost, InLockstepTheCameraIsAlwaysDrawn) {
    HostFixture fixture(15, {.is_lockstep = true});
    fixture.set_up();
    EXPECT_EQ(fixture.bus.subscribers().size(), 1u);
}

TEST(LoopbackHost, InLockstepAReaderGetsNothingThatWasNotAskedFor) {
    HostFixture fixture(15, {.is_lockstep = true});
    fixture.set_up();
    fixture.kernel.reader_comes(video_number);
    fixture.tick();
    const auto latch = stream::DeliveryLatch::create();
    // What a step that was given up had drawn comes without a latch.
    for (const auto& of_step : {latch, std::shared_ptr<stream::DeliveryLatch>()}) {
        ASSERT_TRUE(fixture.bus.publish(++fixture.sequence, fixture.now_ns, std::byte{2}, of_step));
        EXPECT_TRUE(latch->is_open());
        const std::size_t shown = fixture.device().pictures.size();
        for (int i = 0; i < 40; ++i) fixture.tick();
        EXPECT_EQ(fixture.device().pictures.size(), shown);
    }
    const std::size_t shown = fixture.device().pictures.size();
    fixture.kernel.reader_leaves(video_number);
    for (int i = 0; i < 40; ++i) fixture.tick();
    EXPECT_GT(fixture.device().pictures.size(), shown) << "nobody reads";
}

}  // namespace
}  // namespace camrig::device
