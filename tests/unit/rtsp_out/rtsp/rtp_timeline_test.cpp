#include "rtsp_out/rtsp/rtp_timeline.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "core/base/clock.h"
#include "core/base/wall_offset.h"

namespace camrig::rtsp {
namespace {

/// What a client computes: absolute time of a stamp by a sender report (docs/examples/rtsp_times.py).
TimeNs capture_time_ns(std::uint32_t stamp, const RtpTimeline::SenderTime& report) {
    const auto seconds = static_cast<std::int64_t>(report.ntp >> 32) - 2'208'988'800;
    const auto fraction = (report.ntp & 0xffffffffU) * 1'000'000'000U;
    const TimeNs report_ns = seconds * ns_per_s + static_cast<TimeNs>((fraction + (1U << 31)) >> 32);
    const auto ticks = static_cast<std::int32_t>(stamp - report.rtp);
    return report_ns + static_cast<TimeNs>(ticks) * ns_per_s / RtpTimeline::ticks_per_s;
}

TEST(RtpTimeline, TwoStreamsGiveOneInstantTheSameTimeToTheNanosecond) {
    std::mt19937_64 random(1);
    const TimeNs wall_ns = 1'790'000'000'123'456'789;
    for (int i = 0; i < 20'000; ++i) {
        const TimeNs instant_ns = 5 * ns_per_s + static_cast<TimeNs>(random() % (1'000'000 * ns_per_s));
        // Streams begin at different times, with different offsets, and report at different times.
        const auto began = [&] {
            return std::max(ns_per_s * 3, instant_ns - static_cast<TimeNs>(random() % (9000 * ns_per_s)));
        };
        const RtpTimeline left(began(), static_cast<std::uint32_t>(random()), wall_ns);
        const RtpTimeline right(began(), static_cast<std::uint32_t>(random()), wall_ns);
        const auto reported = [&] {
            return instant_ns + static_cast<TimeNs>(random() % (10 * ns_per_s)) - 5 * ns_per_s;
        };
        const TimeNs left_ns = capture_time_ns(left.sender_time(instant_ns).rtp, left.sender_time(reported()));
        const TimeNs right_ns = capture_time_ns(right.sender_time(instant_ns).rtp, right.sender_time(reported()));
        ASSERT_NEAR(static_cast<double>(left_ns - right_ns), 0.0, 2.0) << instant_ns;
        // And it is the last tick before the instant.
        const TimeNs error_ns = instant_ns + wall_ns - left_ns;
        ASSERT_GE(error_ns, -2) << instant_ns;
        ASSERT_LE(error_ns, 11'113) << instant_ns;
    }
}

TEST(RtpTimeline, AnyReportGivesAPictureTheTimeThatItsCameraSays) {
    const TimeNs wall_ns = 1'790'000'000'123'456'789, offset_ns = -4 * ns_per_s, began_ns = 1000 * ns_per_s;
    const RtpTimeline timeline(began_ns, 0xffff0000U, wall_ns);
    // Its clock is fast by 100 ppm since 400 s before the stream; RTP time begins right.
    const auto clock_at = [&](TimeNs now_ns) {
        const TimeNs drift_ns = (now_ns - began_ns + 400 * ns_per_s) / 10'000;
        return StreamClock{.rtp_error_ns = drift_ns - 400 * ns_per_s / 10'000, .ntp_error_ns = offset_ns + drift_ns};
    };
    for (TimeNs instant_ns = began_ns; instant_ns < began_ns + 3000 * ns_per_s; instant_ns += 777'777'777) {
        const StreamClock clock = clock_at(instant_ns);
        const std::uint32_t stamp = timeline.sender_time(instant_ns + clock.rtp_error_ns).rtp;
        for (const TimeNs later_ns : {-3 * ns_per_s, 7 * ns_per_ms, 200 * ns_per_s}) {
            const TimeNs reported_ns = instant_ns + later_ns;
            const auto report = timeline.sender_time(reported_ns, clock_at(reported_ns));
            const TimeNs error_ns = instant_ns + wall_ns + clock.ntp_error_ns - capture_time_ns(stamp, report);
            ASSERT_GE(error_ns, -2) << instant_ns;
            ASSERT_LE(error_ns, 11'113) << instant_ns;
        }
    }
}

TEST(RtpTimeline, StampsAreThoseOfAPayloaderThatRoundsDown) {
    const RtpTimeline timeline(100 * ns_per_s + 7, 0xfffffff0U, 0);
    EXPECT_EQ(timeline.base_ns(), 98 * ns_per_s);
    EXPECT_EQ(timeline.sender_time(98 * ns_per_s).rtp, 0xfffffff0U);
    EXPECT_EQ(timeline.sender_time(98 * ns_per_s + 11'111).rtp, 0xfffffff0U);
    EXPECT_EQ(timeline.sender_time(98 * ns_per_s + 11'112).rtp, 0xfffffff1U);
    EXPECT_EQ(timeline.sender_time(99 * ns_per_s).rtp, 0xfffffff0U + 90'000U);  // wraps around
}

TEST(RtpTimeline, NtpTimeCountsFrom1900) {
    EXPECT_EQ(ntp_from_realtime(0), std::uint64_t{2'208'988'800} << 32);
    EXPECT_EQ(ntp_from_realtime(ns_per_s / 2) & 0xffffffffU, 0x80000000U);
    EXPECT_EQ(ntp_from_realtime(2 * ns_per_s - 0), (std::uint64_t{2'208'988'802} << 32));
    EXPECT_EQ(ntp_from_realtime(-ns_per_s / 4), (std::uint64_t{2'208'988'799} << 32) + 0xc0000000U);
    EXPECT_EQ(ntp_from_realtime(std::int64_t{2'085'978'496} * ns_per_s), 0u);  // 2036-02-07 06:28:16, RFC 5905
}

TEST(WallOffset, IsTheRealTimeClockMinusTheMonotonicOne) {
    WallOffset wall;
    const TimeNs offset_ns = wall.current();
    EXPECT_EQ(offset_ns, wall.current());  // steady, although the clocks are read again
    EXPECT_NEAR(static_cast<double>(monotonic_now_ns() + offset_ns), static_cast<double>(realtime_now_ns()), 50e6);
}

/// Somebody sets CLOCK_REALTIME: streams that begin after that have the new time, one that runs keeps its own.
TEST(WallOffset, FollowsAClockThatIsSetButNotOneThatIsSlewed) {
    TimeNs now_ns = 1'790'000'000 * ns_per_s;
    WallOffset wall([&] { return now_ns; });
    const TimeNs first_ns = wall.current();
    EXPECT_EQ(first_ns, now_ns);
    const RtpTimeline running(1000 * ns_per_s, 0, first_ns);
    for (const TimeNs slewed_ns : {ns_per_ms, -ns_per_ms, 99 * ns_per_ms, -99 * ns_per_ms}) {
        now_ns = first_ns + slewed_ns;
        EXPECT_EQ(wall.current(), first_ns);  // or two streams gave one instant two times
    }
    for (const TimeNs set_ns : {3600 * ns_per_s, -3600 * ns_per_s, 101 * ns_per_ms, -101 * ns_per_ms}) {
        const TimeNs before_ns = wall.current();
        now_ns = before_ns + set_ns;
        EXPECT_EQ(wall.current(), now_ns);
        const RtpTimeline later(1000 * ns_per_s, 0, wall.current());
        EXPECT_EQ(later.realtime_of(2000 * ns_per_s) - running.realtime_of(2000 * ns_per_s), now_ns - first_ns);
    }
    EXPECT_EQ(running.realtime_of(2000 * ns_per_s), 2000 * ns_per_s + first_ns);
}

}  // namespace
}  // namespace camrig::rtsp
