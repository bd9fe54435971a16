#include "core/base/rate.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace camrig {
namespace {

TEST(Rate, FrameTimesHaveNoDriftOverATrillionFrames) {
    const Rate ntsc = Rate::create(30000, 1001).value();
    const std::int64_t n = 1'000'000'000'000;
    // 10^11 frames take 3 336 666 666 s and two thirds.
    EXPECT_EQ(ntsc.time_of_frame(n / 10), 3'336'666'666'666'666'666);
    for (std::int64_t k = 0; k <= 20; ++k) {
        // Every 30000 frames are 1001 s, to the nanosecond.
        const std::int64_t frame = k * (n / 10 / 20 / 30000) * 30000;
        EXPECT_EQ(ntsc.time_of_frame(frame), frame / 30000 * 1001 * ns_per_s);
    }
    const Rate fast = Rate::create(1000, 1).value();
    EXPECT_EQ(fast.time_of_frame(n), n * ns_per_ms);
}

TEST(Rate, FrameTimesAreWithinOneNanosecondUpToTwoToTheFortyFrames) {
    for (const char* text : {"25", "10", "30000/1001", "24000/1001", "59.94", "1000/7", "999"}) {
        const Rate rate = Rate::parse(text).value();
        for (int bit = 0; bit <= 40; ++bit) {
            const std::int64_t n = std::int64_t{1} << bit;
            const long double exact = static_cast<long double>(n) * rate.den() * 1e9L / rate.num();
            if (exact > 4e18L) continue;
            EXPECT_NEAR(static_cast<double>(exact - rate.time_of_frame(n)), 0.0, 1.0) << text << " n=" << n;
        }
    }
}

TEST(Rate, FirstFrameAtOrAfterIsTheInverseOfTimeOfFrame) {
    for (const char* text : {"25", "30000/1001", "1000", "1/10", "0.1", "7/3", "29.97"}) {
        const Rate rate = Rate::parse(text).value();
        for (std::int64_t n : {0LL, 1LL, 2LL, 3LL, 1000LL, 1001LL, 123456789LL}) {
            const TimeNs t = rate.time_of_frame(n);
            EXPECT_EQ(rate.first_frame_at_or_after(t), n) << text;
            EXPECT_EQ(rate.first_frame_at_or_after(t + 1), n + 1) << text;
        }
        EXPECT_EQ(rate.first_frame_at_or_after(-5), 0);
    }
}

TEST(Rate, TheNextFrameIsTheFirstOneAfterATimeAndThoseUntilItAreCounted) {
    const Rate ntsc = *Rate::create(30000, 1001);
    EXPECT_EQ(ntsc.frames_until(-1), 0);
    EXPECT_EQ(ntsc.frames_until(0), 1);
    EXPECT_EQ(ntsc.next_due_ns(-1), 0);
    for (const std::int64_t n : {1, 2, 3, 1'000'000, 1 << 30}) {
        const TimeNs due_ns = ntsc.time_of_frame(n);
        EXPECT_EQ(ntsc.frames_until(due_ns - 1), n);
        EXPECT_EQ(ntsc.frames_until(due_ns), n + 1);
        EXPECT_EQ(ntsc.next_due_ns(due_ns - 1), due_ns);
        EXPECT_EQ(ntsc.next_due_ns(due_ns), ntsc.time_of_frame(n + 1));
    }
}

TEST(Rate, NumbersAreTakenAsTheDecimalThatNamesThem) {
    EXPECT_EQ(Rate::from_number(0.1).value(), Rate::create(1, 10).value());
    EXPECT_EQ(Rate::from_number(29.97).value(), Rate::create(2997, 100).value());
    EXPECT_EQ(Rate::from_number(1000).value(), Rate::create(1000, 1).value());
    EXPECT_EQ(Rate::from_number(25).value().to_string(), "25");
    EXPECT_EQ(Rate::parse("60000/2002").value().to_string(), "30000/1001");
    for (const auto& [num, den] : {std::pair{30000, 1001}, {60000, 1001}, {24000, 1001}, {1, 3}, {1000, 7}})
        EXPECT_EQ(Rate::from_number(static_cast<double>(num) / den).value(), Rate::create(num, den).value());
    EXPECT_EQ(Rate::from_number(1.0 / 3.0).value().to_string(), "1/3");
    EXPECT_FALSE(Rate::from_number(1.0e-2));
    EXPECT_FALSE(Rate::from_number(1000.0000000000001));
}

TEST(Rate, WhatIsNoRateIsRefusedWithTheReason) {
    for (const char* text : {"0", "-1", "1001", "1/11", "1/0", "0/5", "a", "", "5/", "/5", "1e99", "1e-2147483648",
                             "nan", "25 ", "1.5/2", "99999999999999999999999", "1/2/3"}) {
        const auto rate = Rate::parse(text);
        ASSERT_FALSE(rate) << text;
        EXPECT_EQ(rate.error().kind, ErrorKind::invalid_argument);
        EXPECT_NE(rate.error().message.find("1/10 to 1000"), std::string::npos);
    }
    EXPECT_FALSE(Rate::from_number(0.0 / 0.0));
}

// Exact integer schedules give the full count where float comparisons lose frames (20 Hz: 134 of 200 in a known
// report).
TEST(Rate, TwoHundredOfTwoHundredFramesFallDue) {
    for (const char* text : {"10", "20", "25", "30", "50", "30000/1001"}) {
        const Rate rate = Rate::parse(text).value();
        const TimeNs end = rate.time_of_frame(200);
        int due = 0;
        for (TimeNs step = 0; step < end; step += 1'000'000) {
            const TimeNs next = std::min(step + 1'000'000, end);
            due += static_cast<int>(rate.first_frame_at_or_after(next) - rate.first_frame_at_or_after(step));
        }
        EXPECT_EQ(due, 200) << text;
    }
}

}  // namespace
}  // namespace camrig
