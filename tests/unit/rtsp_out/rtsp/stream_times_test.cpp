#include "rtsp_out/rtsp/stream_times.h"

#include <gtest/gtest.h>

namespace camrig::rtsp {
namespace {

constexpr TimeNs second = ns_per_s;
const RtpTimeline timeline(100 * second, 0, 0);

/// Of a picture at this world time, by a clock that is so wrong.
frame::FrameInfo picture(TimeNs world_ns, std::optional<TimeNs> steady_error_ns) {
    frame::FrameInfo info;
    info.world_ns = world_ns;
    if (steady_error_ns) info.clock.emplace().steady_error_ns = *steady_error_ns;
    return info;
}

TEST(StreamTimes, AreThoseOfTheTimelineByACameraWithoutAClock) {
    StreamTimes times(timeline);
    for (const TimeNs at : {101 * second, 102 * second, 105 * second})
        EXPECT_EQ(times.next_pts(picture(at, {}), at), timeline.pts_of(at));
}

TEST(StreamTimes, RiseByATickEvenWhereStampsDoNot) {
    StreamTimes times(timeline);
    TimeNs last = times.next_pts(picture(0, {}), 101 * second);
    for (const TimeNs stamp : {101 * second, 100 * second, 101 * second + 1}) {
        const TimeNs pts = times.next_pts(picture(0, {}), stamp);
        EXPECT_GT((pts * RtpTimeline::ticks_per_s) / second, (last * RtpTimeline::ticks_per_s) / second);
        last = pts;
    }
}

TEST(StreamTimes, FollowHowAClockDriftsAndNotByHowMuchItWasOffAtFirst) {
    StreamTimes times(timeline);
    EXPECT_EQ(times.next_pts(picture(1 * second, 7 * second), 101 * second), timeline.pts_of(101 * second));
    EXPECT_EQ(times.next_pts(picture(2 * second, 7 * second + 500), 102 * second), timeline.pts_of(102 * second) + 500);
}

TEST(StreamTimes, GoOnWhereAClockIsTakenAwayOrGivenOrAnotherWorldBegins) {
    StreamTimes times(timeline);
    times.next_pts(picture(1 * second, 0), 101 * second);
    EXPECT_EQ(times.next_pts(picture(2 * second, 500), 102 * second), timeline.pts_of(102 * second) + 500);
    EXPECT_EQ(times.next_pts(picture(3 * second, {}), 103 * second), timeline.pts_of(103 * second) + 500);
    EXPECT_EQ(times.next_pts(picture(4 * second, 9 * second), 104 * second), timeline.pts_of(104 * second) + 500);
    EXPECT_EQ(times.next_pts(picture(1 * second, 2 * second), 105 * second), timeline.pts_of(105 * second) + 500)
        << "the world's time went back";
}

TEST(StreamTimes, OfASensorsPictureIsTheStartOfItsExposure) {
    StreamTimes times(timeline);
    frame::FrameInfo info = picture(1 * second, 500);
    info.sensor.emplace().exposure_start_ns = info.world_ns - 30 * ns_per_ms;
    EXPECT_EQ(times.next_pts(info, 101 * second), timeline.pts_of(101 * second - 30 * ns_per_ms));
}

}  // namespace
}  // namespace camrig::rtsp
