#include "core/camera/clock.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/camera/clock_noise.h"

namespace camrig::camera::clock_test {
namespace {

constexpr TimeNs ms = ns_per_ms, s = ns_per_s, year = 365 * 86'400 * ns_per_s;

ClockReading at(const Clock& clock, TimeNs world_ns) {
    return clock.at(world_ns).value();
}

TEST(Clock, WithoutOneNothingIsSaid) {
    EXPECT_EQ(Clock().at(5 * s), std::nullopt);
}

TEST(Clock, OffsetAndDriftAreExactAlsoAfterYears) {
    const Clock clock(ClockSpec{.offset_ns = -7 * ms, .drift_ppb = 20'001});
    EXPECT_EQ(at(clock, 0), (ClockReading{-7 * ms, -7 * ms, 20'001}));
    EXPECT_EQ(at(clock, s), (ClockReading{-7 * ms + 20'001, -7 * ms + 20'001, 20'001}));
    EXPECT_EQ(at(clock, 100 * year).stamp_error_ns, -7 * ms + TimeNs{100} * 365 * 86'400 * 20'001);
    // Nothing gained or lost by rounding: it is the floor.
    EXPECT_EQ(at(clock, 49'997), (ClockReading{-7 * ms, -7 * ms, 20'001}));
    EXPECT_EQ(at(clock, 49'998), (ClockReading{-7 * ms + 1, -7 * ms + 1, 20'001}));
    EXPECT_EQ(at(Clock(ClockSpec{.drift_ppb = -1}), 1).stamp_error_ns, -1);
}

TEST(Clock, ItsMonotonicClockKnowsNothingOfSteps) {
    Clock clock(ClockSpec{.offset_ns = 3 * ms, .drift_ppb = 1000, .step_ns = -90 * s, .step_at_ns = 10 * s});
    EXPECT_EQ(at(clock, 10 * s - 1).stamp_error_ns, 3 * ms + 9'999);
    EXPECT_EQ(at(clock, 10 * s).stamp_error_ns, 3 * ms + 10'000 - 90 * s);
    EXPECT_EQ(at(clock, 10 * s).steady_error_ns, 3 * ms + 10'000);
    clock.set(ClockSpec{.offset_ns = 5 * s, .drift_ppb = 1000}, 20 * s + 1);
    EXPECT_EQ(at(clock, 20 * s + 1), (ClockReading{5 * s + 20'000, 3 * ms + 20'000, 1000}));
    clock.set(ClockSpec{.offset_ns = 5 * s, .drift_ppb = 1000, .jitter_ns = 0, .phase_ns = 7}, 30 * s + 999'999);
    EXPECT_EQ(at(clock, 31 * s), (ClockReading{5 * s + 31'000, 3 * ms + 31'000, 1000}));  // nothing lost by rounding
}

TEST(Clock, TheDriftThatItTellsIsItsSlopeAlsoWhenItIsPulledAndWhenItsMasterIsLost) {
    const auto slope_ppb = [](const Clock& clock, TimeNs world_ns) {
        return (at(clock, world_ns + 100 * s).steady_error_ns - at(clock, world_ns).steady_error_ns) / 100;
    };
    Clock clock(ClockSpec{.drift_ppb = 50'000, .seed = 3});
    EXPECT_EQ(at(clock, s).drift_ppb, slope_ppb(clock, s));
    clock.set(ClockSpec{.state = ClockState::ptp, .drift_ppb = 50'000, .seed = 3},
              10'000 * s);  // 0.5 s wrong: 1000 s to pull
    EXPECT_EQ(at(clock, 10'000 * s).drift_ppb, -500'000);
    EXPECT_NEAR(static_cast<double>(slope_ppb(clock, 10'000 * s)), -500'000, 20);  // but for PTP's 0.5 us
    EXPECT_EQ(at(clock, 12'000 * s).drift_ppb, 0);
    clock.set(ClockSpec{.state = ClockState::ptp_lost, .seed = 3}, 13'000 * s);
    const std::int64_t lost_ppb = at(clock, 13'000 * s).drift_ppb;
    EXPECT_NEAR(static_cast<double>(std::abs(lost_ppb)), 550, 450);
    EXPECT_NEAR(static_cast<double>(slope_ppb(clock, 13'000 * s)), static_cast<double>(lost_ppb), 1);
}

TEST(Clock, AnotherDriftBendsItWhereItIs) {
    Clock clock(ClockSpec{.offset_ns = 100, .drift_ppb = 50'000});
    clock.set(ClockSpec{.offset_ns = 100, .drift_ppb = -10'000}, 4 * s);
    EXPECT_EQ(at(clock, 4 * s - 1).stamp_error_ns, 100 + 199'999);
    EXPECT_EQ(at(clock, 4 * s).stamp_error_ns, 100 + 200'000);
    EXPECT_EQ(at(clock, 6 * s).stamp_error_ns, 100 + 180'000);
    clock.set(std::nullopt, 7 * s);
    EXPECT_EQ(clock.at(7 * s), std::nullopt);
    EXPECT_EQ(at(clock, 7 * s - 1).stamp_error_ns, 100 + 170'000);
    clock.set(ClockSpec{.drift_ppb = 1}, 8 * s);  // one where none was counts from world time 0
    EXPECT_EQ(at(clock, 9 * s).stamp_error_ns, 9);
}

TEST(Clock, JitterHasItsDeviationAndIsOfTheInstantAlone) {
    const Clock clock(ClockSpec{.jitter_ns = 10'000, .seed = 3}), other(ClockSpec{.jitter_ns = 10'000, .seed = 4});
    double sum = 0, squares = 0;
    int same = 0;
    constexpr int count = 20'000;
    for (int i = count - 1; i >= 0; --i) {
        const auto error = static_cast<double>(at(clock, i * 40 * ms).stamp_error_ns);
        EXPECT_LE(std::abs(error), 34'700);
        sum += error;
        squares += error * error;
        same += at(clock, i * 40 * ms) == at(other, i * 40 * ms);
    }
    EXPECT_NEAR(sum / count, 0, 4 * 10'000 / std::sqrt(count));
    EXPECT_NEAR(std::sqrt(squares / count), 10'000, 200);
    EXPECT_LT(same, 20);
}

TEST(Clock, ItsSteadyClockNeverGoesBackHoweverLargeTheJitter) {
    const Clock clock(ClockSpec{.offset_ns = -5 * s, .drift_ppb = -1'000'000, .jitter_ns = s, .seed = 5});
    const TimeNs period = 40 * ms;
    bool steps_back = false;
    for (TimeNs t = period; t < 400 * s; t += period) {
        const ClockReading before = clock.at(t - period, period).value(), now = clock.at(t, period).value();
        ASSERT_GT(t + now.steady_error_ns, t - period + before.steady_error_ns + 1000) << t;
        steps_back = steps_back || t + now.stamp_error_ns < t - period + before.stamp_error_ns;
    }
    EXPECT_TRUE(steps_back);  // the time of day has all of it
}

TEST(Clock, ARandomWalkGrowsWithTheRootOfTheTime) {
    // Of many walks, what is between two times has the deviation of that time, near the beginning and years later.
    for (const TimeNs begin : {TimeNs{0}, 3 * s + 1, 2 * year}) {
        for (const TimeNs span : {10 * s, 1'000 * s, 86'400 * s}) {
            double squares = 0;
            constexpr int walks = 2'000;
            for (std::uint64_t seed = 0; seed < walks; ++seed) {
                const Clock clock(ClockSpec{.walk_ns = 1'000, .seed = seed});
                const auto moved =
                    at(clock, begin + span).stamp_error_ns - (begin == 0 ? 0 : at(clock, begin).stamp_error_ns);
                squares += static_cast<double>(moved) * static_cast<double>(moved);
            }
            const double expected = 1'000 * std::sqrt(static_cast<double>(span) / 1e9);
            EXPECT_NEAR(std::sqrt(squares / walks), expected, 0.07 * expected) << begin << " " << span;
        }
    }
}

TEST(Clock, ARandomWalkHasNoJumps) {
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        TimeNs last = walk_ns(seed, 0, 1'000);
        EXPECT_EQ(last, 0);
        for (TimeNs t = ms; t < 3 * s; t += ms) {
            const TimeNs now = walk_ns(seed, t, 1'000);
            EXPECT_LE(std::abs(now - last), 6) << seed << " " << t;
            last = now;
        }
    }
}

TEST(Clock, IsTheSameInWhateverOrderItIsAsked) {
    const Clock clock(ClockSpec{.drift_ppb = 30'000, .walk_ns = 500, .jitter_ns = 2'000, .seed = 9});
    std::vector<ClockReading> forwards;
    for (int i = 0; i < 500; ++i) forwards.push_back(at(clock, i * 40 * ms));
    for (int i = 499; i >= 0; i -= 7) EXPECT_EQ(at(clock, i * 40 * ms), forwards[static_cast<std::size_t>(i)]);
}

TEST(Clock, AServerPullsItAtFiveHundredPpmAndKeepsIt) {
    Clock clock(ClockSpec{.offset_ns = 2 * ms, .drift_ppb = 100'000});
    clock.set(ClockSpec{.state = ClockState::ntp, .offset_ns = 2 * ms, .drift_ppb = 100'000}, 1'000 * s);
    EXPECT_EQ(at(clock, 1'000 * s).stamp_error_ns, 102 * ms);  // nothing jumps
    EXPECT_NEAR(static_cast<double>(at(clock, 1'100 * s).stamp_error_ns), 52.0 * ms, 1.0 * ms);
    for (TimeNs t = 1'300 * s; t < 20'000 * s; t += 7 * s) {
        EXPECT_LE(std::abs(at(clock, t).stamp_error_ns - 2 * ms), ms / 2) << t;
        EXPECT_EQ(at(clock, t).stamp_error_ns, at(clock, t).steady_error_ns) << t;
    }
}

TEST(Clock, AServerSetsAClockThatIsWrongByMoreThanASecond) {
    Clock clock(ClockSpec{.drift_ppb = 1'000'000});
    clock.set(ClockSpec{.state = ClockState::ptp}, 2'000 * s);
    EXPECT_LE(std::abs(at(clock, 2'000 * s).stamp_error_ns), 500);
    EXPECT_NEAR(static_cast<double>(at(clock, 2'000 * s).steady_error_ns), 2.0 * s, 0.5);
}

TEST(Clock, ALostMasterLeavesAClockThatDriftsSlowlyFromWhereItWas) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        Clock clock(ClockSpec{.state = ClockState::ptp, .seed = seed});
        const TimeNs before = at(clock, 50 * s).stamp_error_ns;
        EXPECT_LE(std::abs(before), 500);
        clock.set(ClockSpec{.state = ClockState::ptp_lost, .seed = seed}, 50 * s);
        EXPECT_EQ(at(clock, 50 * s).stamp_error_ns, before);
        const double ppb = static_cast<double>(at(clock, 1'050 * s).stamp_error_ns - before) / 1'000;
        EXPECT_GE(std::abs(ppb), 99) << seed;
        EXPECT_LE(std::abs(ppb), 1'001) << seed;
    }
}

TEST(Clock, ACameraThatTellsTaiIsThirtySevenSecondsAhead) {
    const Clock clock(ClockSpec{.state = ClockState::tai});
    EXPECT_NEAR(static_cast<double>(at(clock, 3 * s).stamp_error_ns), 37.0 * s, 500);
    EXPECT_EQ(at(clock, 3 * s).stamp_error_ns, at(clock, 3 * s).steady_error_ns);
}

/// Whatever it is told, its monotonic clock has no jump, and the kept past is as it was.
TEST(Clock, CommandsChangeNothingBeforeThemAndNeverStepItsMonotonicClock) {
    const auto random = [](std::uint64_t i, std::uint64_t what) { return random_bits(7, what, i); };
    Clock clock(ClockSpec{});
    TimeNs now = 0;
    for (std::uint64_t i = 0; i < 2'000; ++i) {
        now += 1 + static_cast<TimeNs>(random(i, 0) % (100 * ms));
        const TimeNs ago = std::max<TimeNs>(0, now - 200 * ms);
        const ClockReading past = at(clock, ago), before = at(clock, now);
        clock.set(ClockSpec{.state = static_cast<ClockState>(random(i, 1) % 5),
                            .offset_ns = static_cast<TimeNs>(random(i, 2) % (20 * s)) - 10 * s,
                            .drift_ppb = static_cast<std::int64_t>(random(i, 3) % 2'000'001) - 1'000'000,
                            .walk_ns = static_cast<std::int64_t>(random(i, 4) % 1'000),
                            .seed = random(i, 5) % 10},
                  now);
        EXPECT_EQ(at(clock, ago), past) << i;
        EXPECT_EQ(at(clock, now).steady_error_ns, before.steady_error_ns) << i;
    }
}

}  // namespace
}  // namespace camrig::camera::clock_test
