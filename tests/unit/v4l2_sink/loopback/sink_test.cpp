#include <gmock/gmock.h>

#include "core/base/clock.h"
#include "tests/unit/v4l2_sink/loopback/fake_bus.h"
#include "tests/unit/v4l2_sink/loopback/fake_module.h"
#include "v4l2_sink/loopback/loopback_sink.h"

namespace camrig::device {
namespace {

const LoopbackFormat lobby_format{V4L2_PIX_FMT_YUYV, {64, 48}, *Rate::create(25, 1)};

class LoopbackSinkTest : public testing::Test {
protected:
    LoopbackSinkTest() {
        kernel_.plug(video_number);
        stream::StreamInfo info;
        info.stats = stats_;
        EXPECT_TRUE(sink_.open(info));
    }
    static std::unique_ptr<LoopbackDevice> open_device(FakeModule& kernel) {
        kernel.plug(video_number);
        return std::move(*LoopbackDevice::open(kernel, *LoopbackModule(kernel).features(), video_number, lobby_format));
    }
    stream::MediaUnit unit(std::int64_t sequence, TimeNs monotonic_ns, std::byte value = std::byte{1}) {
        return FakeBus::unit(*media_format_of(lobby_format), sequence, monotonic_ns, value);
    }
    const std::vector<ReadPicture>& pictures() { return kernel_.devices.at(video_number).pictures; }

    FakeModule kernel_{15};
    std::shared_ptr<stream::ReaderStats> stats_ = std::make_shared<stream::ReaderStats>();
    LoopbackSink sink_{open_device(kernel_)};
    const TimeNs now_ = monotonic_now_ns();
};

TEST_F(LoopbackSinkTest, StampsAreTheInstantForEveryCameraOfIt) {
    FakeModule other_kernel(15);
    LoopbackSink other(open_device(other_kernel));
    stream::StreamInfo info;
    info.stats = std::make_shared<stream::ReaderStats>();
    ASSERT_TRUE(other.open(info));
    for (int i = 0; i < 3; ++i) {
        const TimeNs instant_ns = now_ - ns_per_s + i * 40 * ns_per_ms + 123;
        ASSERT_TRUE(sink_.write(unit(i, instant_ns)));
        ASSERT_TRUE(other.write(unit(i + 7, instant_ns)));
        EXPECT_EQ(pictures().back().stamp_us, instant_ns / 1000);
        EXPECT_EQ(other_kernel.devices.at(video_number).pictures.back().stamp_us, instant_ns / 1000);
    }
    EXPECT_EQ(stats_->delivered, 3u);
}

TEST_F(LoopbackSinkTest, StampsRiseStrictlyAndAreNeverInTheFuture) {
    const TimeNs same_ns = now_ - ns_per_ms;
    ASSERT_TRUE(sink_.write(unit(0, same_ns)));
    ASSERT_TRUE(sink_.write(unit(1, same_ns)));       // a changed camera of a paused world
    ASSERT_TRUE(sink_.write(unit(2, same_ns - 50)));  // within the same microsecond
    EXPECT_EQ(pictures()[1].stamp_us, pictures()[0].stamp_us + 1);
    EXPECT_EQ(pictures()[2].stamp_us, pictures()[1].stamp_us + 1);
    ASSERT_TRUE(sink_.write(unit(3, now_ + 3600 * ns_per_s)));
    EXPECT_LE(pictures()[3].stamp_us, monotonic_now_ns() / 1000);
}

TEST_F(LoopbackSinkTest, ASilentDeviceRepeatsItsLastPictureWithAFreshStamp) {
    ASSERT_TRUE(sink_.write(unit(0, now_, std::byte{7})));
    ASSERT_TRUE(sink_.repeat_if_silent(now_ + ns_per_s));
    EXPECT_EQ(pictures().size(), 1u);
    TimeNs time_ns = now_;
    for (int i = 0; i < 40; ++i) ASSERT_TRUE(sink_.repeat_if_silent(time_ns += 250 * ns_per_ms));
    ASSERT_GE(pictures().size(), 6u);  // ten seconds: one at least every two
    for (std::size_t i = 1; i < pictures().size(); ++i) {
        EXPECT_EQ(pictures()[i].bytes, pictures()[0].bytes);
        EXPECT_GT(pictures()[i].stamp_us, pictures()[i - 1].stamp_us);
        EXPECT_LE(pictures()[i].stamp_us - pictures()[i - 1].stamp_us, 2'000'000);
    }
    EXPECT_LE(pictures().back().stamp_us, time_ns / 1000);
}

TEST_F(LoopbackSinkTest, ASlowCameraIsNotSilentBetweenItsPictures) {
    sink_.with_device([](LoopbackDevice& node) { node.change_rate(*Rate::create(1, 5)); });
    ASSERT_TRUE(sink_.write(unit(0, now_)));
    ASSERT_TRUE(sink_.repeat_if_silent(now_ + 9 * ns_per_s));
    EXPECT_EQ(pictures().size(), 1u);
    ASSERT_TRUE(sink_.repeat_if_silent(now_ + 11 * ns_per_s));
    EXPECT_EQ(pictures().size(), 2u);
}

TEST_F(LoopbackSinkTest, WhatAFaultHoldsBackIsNotReplacedByTheLastPicture) {
    ASSERT_TRUE(sink_.write(unit(0, now_)));
    sink_.hold_back();
    ASSERT_TRUE(sink_.repeat_if_silent(now_ + 60 * ns_per_s));
    EXPECT_EQ(pictures().size(), 1u);
    ASSERT_TRUE(sink_.write(unit(2, now_ + ns_per_s)));
    ASSERT_TRUE(sink_.repeat_if_silent(now_ + 60 * ns_per_s));
    EXPECT_EQ(pictures().size(), 3u);
    sink_.hold_back();
    sink_.close();  // nobody reads: it shows what there is
    ASSERT_TRUE(sink_.repeat_if_silent(now_ + 90 * ns_per_s));
    EXPECT_EQ(pictures().size(), 4u);
}

TEST_F(LoopbackSinkTest, APictureThatWasDrawnWhileOneWasRepeatedKeepsItsInstant) {
    ASSERT_TRUE(sink_.write(unit(0, now_ - 10 * ns_per_s)));
    ASSERT_TRUE(sink_.repeat_if_silent(now_ + 2 * ns_per_s));
    const TimeNs instant_ns = now_ + 2 * ns_per_s - 400 * ns_per_ms;
    EXPECT_LT(pictures().back().stamp_us, instant_ns / 1000);
}

TEST_F(LoopbackSinkTest, ACameraWhosePicturesAreLateRepeatsThemWithAnOlderStamp) {
    ASSERT_TRUE(sink_.write(unit(0, now_ - 1'500 * ns_per_ms)));
    ASSERT_TRUE(sink_.repeat_if_silent(now_ + 2 * ns_per_s));
    EXPECT_EQ(pictures().size(), 2u);
    EXPECT_LT(pictures().back().stamp_us, (now_ + 400 * ns_per_ms) / 1000);
}

TEST_F(LoopbackSinkTest, ARepeatedPictureIsStampedByTheCamerasClockSoThatTheNextIsNotStuckBehindIt) {
    stream::MediaUnit behind = unit(0, now_ - 10 * ns_per_s);
    behind.info.clock = ClockReading{.stamp_error_ns = -5 * ns_per_s, .steady_error_ns = -5 * ns_per_s};
    ASSERT_TRUE(sink_.write(behind));
    ASSERT_TRUE(sink_.repeat_if_silent(now_ + 2 * ns_per_s));
    EXPECT_EQ(pictures().size(), 2u);
    EXPECT_LT(pictures().back().stamp_us, (now_ + 2 * ns_per_s - 5 * ns_per_s) / 1000);
}

TEST_F(LoopbackSinkTest, AFetchedPictureIsShownOnceAndNeverOlderThanWhatIsThere) {
    EXPECT_FALSE(sink_.has_picture());
    ASSERT_TRUE(sink_.refresh(unit(5, now_ - ns_per_ms), now_));
    EXPECT_TRUE(sink_.has_picture());
    EXPECT_EQ(pictures().back().stamp_us, (now_ - ns_per_ms) / 1000);
    ASSERT_TRUE(sink_.refresh(unit(5, now_ - ns_per_ms), now_ + ns_per_s));
    ASSERT_TRUE(sink_.refresh(unit(4, now_ - ns_per_ms), now_ + ns_per_s));
    EXPECT_EQ(pictures().size(), 1u);
}

TEST_F(LoopbackSinkTest, AFetchedPictureOfAWorldThatStandsGetsAStampThatProgramsBelieve) {
    ASSERT_TRUE(sink_.refresh(unit(5, now_ - 3600 * ns_per_s), now_));
    EXPECT_GE(pictures().back().stamp_us, (now_ - ns_per_s) / 1000);
    EXPECT_LE(pictures().back().stamp_us, now_ / 1000);
}

TEST_F(LoopbackSinkTest, AFailedWriteEndsTheSubscriptionInsteadOfBeingRetried) {
    kernel_.write_problem = ENODEV;
    const auto written = sink_.write(unit(0, now_));
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().kind, ErrorKind::unavailable);
    EXPECT_EQ(stats_->delivered, 0u);
}

TEST_F(LoopbackSinkTest, AGivenUpDeviceIsClosedAndCountsWhatComesAsDropped) {
    sink_.give_up();
    EXPECT_EQ(kernel_.open_descriptors(), 0u);
    ASSERT_TRUE(sink_.write(unit(0, now_)));
    EXPECT_EQ(stats_->dropped, 1u);
}

}  // namespace
}  // namespace camrig::device
