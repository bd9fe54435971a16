#include "rtsp_out/rtsp/pictures_on_way.h"

#include <gtest/gtest.h>

namespace camrig::rtsp {
namespace {

/// A picture of this stream time that a reader waits for.
PictureOnWay picture(TimeNs pts, const std::shared_ptr<stream::ReaderStats>& stats) {
    PictureOnWay made{.pts = pts, .times = {}, .bytes = {}, .faults = {}, .pending = {}};
    made.pending = std::make_shared<PendingPicture>();
    made.pending->stats = stats;
    return made;
}

TEST(PicturesOnWay, WhatIsPassedByALaterOneIsDropped) {
    const auto stats = std::make_shared<stream::ReaderStats>();
    PicturesOnWay on_way;
    for (const TimeNs pts : {1, 2, 3}) on_way.add(picture(pts, stats));
    EXPECT_FALSE(on_way.take(0));
    EXPECT_EQ(stats->dropped, 0);
    {
        const auto taken = on_way.take(2);
        ASSERT_TRUE(taken);
        EXPECT_EQ(taken->pts, 2);
        EXPECT_EQ(stats->dropped, 1) << "the first never came out";
        taken->pending->sent_bytes = 100;
    }
    EXPECT_EQ(stats->delivered, 1);
    EXPECT_EQ(stats->bytes, 100);
    EXPECT_FALSE(on_way.take(2)) << "it was taken";
    on_way.clear();
    EXPECT_EQ(stats->dropped, 2);
}

TEST(PicturesOnWay, AreBounded) {
    const auto stats = std::make_shared<stream::ReaderStats>();
    PicturesOnWay on_way;
    constexpr auto most = static_cast<TimeNs>(PicturesOnWay::most);
    for (TimeNs pts = 0; pts < most + 3; ++pts) on_way.add(picture(pts, stats));
    EXPECT_EQ(stats->dropped, 3);
    EXPECT_FALSE(on_way.take(2));
    EXPECT_TRUE(on_way.take(3));
}

TEST(PicturesOnWay, ThoseThatAreSentAgainPushNoneOutThatIsWaitedFor) {
    const auto stats = std::make_shared<stream::ReaderStats>();
    PicturesOnWay on_way;
    constexpr auto most = static_cast<TimeNs>(PicturesOnWay::most);
    on_way.add(picture(0, stats));
    for (TimeNs pts = 1; pts < 2 * most; ++pts)
        on_way.add({.pts = pts, .times = {}, .bytes = {}, .faults = {}, .pending = {}});
    EXPECT_EQ(stats->dropped, 0);
    EXPECT_TRUE(on_way.take(0));
}

}  // namespace
}  // namespace camrig::rtsp
