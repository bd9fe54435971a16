#include "core/camera/timeline.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/camera/camera_state.h"

namespace camrig::camera {
namespace {

Intrinsics focal(double fx) {
    return {fx, 2.0 * fx, 319.5, 239.5};
}

Pose pose(double x, double pan_deg, double tilt_deg) {
    constexpr double deg = std::numbers::pi / 180.0;
    return pose_from_angles({x, -x, 1.0}, {pan_deg * deg, tilt_deg * deg, 0.0}).value();
}

TEST(Timeline, IsThereFromItsEndOnToTheBitAndWasThereUntilItsBegin) {
    Timeline<Pose> timeline(pose(0, 10, 0));
    timeline.go_to(pose(3, 200, 30), 1'000, 777);
    EXPECT_EQ(timeline.at(0), pose(0, 10, 0));
    EXPECT_EQ(timeline.at(1'000), pose(0, 10, 0));
    EXPECT_NE(timeline.at(1'001), pose(0, 10, 0));
    EXPECT_NE(timeline.at(1'776), pose(3, 200, 30));
    EXPECT_EQ(timeline.at(1'777), pose(3, 200, 30));
    EXPECT_EQ(timeline.at(max_time_ns), pose(3, 200, 30));
    EXPECT_EQ(timeline.arrives_ns(), 1'777);
}

TEST(Timeline, AHeadTurnsTheShorterWayRoundAndKeepsTheHorizonLevel) {
    Timeline<Pose> timeline(pose(0, 170, -20));
    timeline.go_to(pose(4, -150, 40), 0, 8 * ns_per_s);
    for (TimeNs t = 0; t <= 8 * ns_per_s; t += 123'456'789) {
        const double share = static_cast<double>(t) / (8.0 * ns_per_s);
        const Pose there = timeline.at(t), expected = pose(4 * share, 170 + 40 * share, -20 + 60 * share);
        EXPECT_NEAR(glm::length(there.position - expected.position), 0.0, 1e-14) << t;
        EXPECT_NEAR(std::abs(glm::dot(there.orientation, expected.orientation)), 1.0, 1e-14) << t;
        EXPECT_NEAR(angles_of(there.orientation).roll, 0.0, 1e-14) << t;
    }
}

TEST(Timeline, AZoomChangesByEqualFactorsInEqualTimes) {
    Timeline<Intrinsics> timeline(focal(200));
    timeline.go_to(focal(3200), 5, 4 * ns_per_s);
    for (int second = 0; second <= 4; ++second) {
        const Intrinsics k = timeline.at(5 + second * ns_per_s);
        EXPECT_NEAR(k.fx, 200 * std::pow(2.0, second), 1e-10);
        EXPECT_NEAR(k.fy, 2 * k.fx, 1e-10);
        EXPECT_EQ(k.cx, 319.5);
    }
}

TEST(Timeline, ACommandInTheMiddleGoesOnFromWhereItIs) {
    Timeline<Intrinsics> timeline(focal(100));
    timeline.go_to(focal(400), 0, 2 * ns_per_s);
    timeline.go_to(focal(100), ns_per_s, ns_per_s);
    EXPECT_NEAR(timeline.at(ns_per_s).fx, 200, 1e-10);
    EXPECT_NEAR(timeline.at(ns_per_s + ns_per_s / 2).fx, std::sqrt(200.0 * 100.0), 1e-10);
    EXPECT_EQ(timeline.at(2 * ns_per_s), focal(100));
}

TEST(Timeline, TwoCommandsAtOneTimeAreTheLastFromWhereTheFirstJumped) {
    Timeline<Intrinsics> timeline(focal(100));
    timeline.go_to(focal(400), 1'000, 0);
    timeline.go_to(focal(100), 1'000, 10);
    EXPECT_EQ(timeline.at(999), focal(100));
    EXPECT_EQ(timeline.at(1'000), focal(400));
    EXPECT_EQ(timeline.at(1'010), focal(100));
}

/// Random commands; after each of them, times of the kept past and of what is to come, in any order and again.
TEST(Timeline, IsTheSameInWhateverOrderItIsAskedAndACommandChangesNothingBeforeIt) {
    struct Sample {
        TimeNs at_ns;
        Pose pose;
        Intrinsics intrinsics;
    };
    for (std::uint64_t run = 0; run < 40; ++run) {
        std::uint64_t drawn = 0;
        const auto random = [&](double most) { return most * random_unit(11, run, drawn++); };
        Timeline<Pose> head(pose(0, 0, 0));
        Timeline<Intrinsics> lens(focal(300));
        std::vector<Sample> past;  // before the next command: known for good
        TimeNs now_ns = 0;
        for (int command = 0; command < 60; ++command) {
            for (const Sample& sample : past) {
                if (sample.at_ns < now_ns - Timeline<Pose>::kept_ns) continue;
                ASSERT_EQ(head.at(sample.at_ns), sample.pose) << sample.at_ns << " at " << now_ns;
                ASSERT_EQ(lens.at(sample.at_ns), sample.intrinsics) << sample.at_ns << " at " << now_ns;
            }
            const auto duration_ns = random(1) < 0.3 ? 0 : static_cast<TimeNs>(random(400e6));
            if (random(1) < 0.7) head.go_to(pose(random(9), random(720) - 360, random(178) - 89), now_ns, duration_ns);
            if (random(1) < 0.7) lens.go_to(focal(50 + random(900)), now_ns, duration_ns);
            const TimeNs next_ns = now_ns + 1 + static_cast<TimeNs>(random(1) < 0.2 ? 0 : random(90e6));
            for (int i = 0; i < 8; ++i) {
                const TimeNs at_ns = now_ns + static_cast<TimeNs>(random(static_cast<double>(next_ns - now_ns)));
                past.push_back({at_ns, head.at(at_ns), lens.at(at_ns)});
            }
            now_ns = next_ns;
        }
    }
}

TEST(Timeline, CommandsWithoutEndKeepTheNewestAndStaySmall) {
    Timeline<Intrinsics> timeline(focal(1));
    for (int i = 1; i <= 100'000; ++i) timeline.go_to(focal(i), i, 0);
    EXPECT_EQ(timeline.at(100'000), focal(100'000));
    EXPECT_EQ(timeline.at(99'990), focal(99'990));
    EXPECT_GE(timeline.at(0).fx, 100'000 - static_cast<int>(Timeline<Intrinsics>::max_segments));
}

}  // namespace
}  // namespace camrig::camera
