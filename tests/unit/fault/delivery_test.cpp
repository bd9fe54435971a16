#include "core/fault/delivery.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/unit/fault/faulty.h"

namespace camrig::fault {
namespace {

constexpr int frames = 20'000;

std::vector<bool> drops_of(const FaultRef& fault) {
    std::vector<bool> drops;
    for (int i = 0; i < frames; ++i) drops.push_back(is_dropped(at_frame(fault, i)));
    return drops;
}

double share_of(const std::vector<bool>& flags) {
    return static_cast<double>(std::ranges::count(flags, true)) / static_cast<double>(flags.size());
}

double mean_run(const std::vector<bool>& flags) {
    std::int64_t runs = 0;
    for (std::size_t i = 1; i < flags.size(); ++i) runs += flags[i] && !flags[i - 1];
    return static_cast<double>(std::ranges::count(flags, true)) / static_cast<double>(runs);
}

TEST(Drop, LosesTheShareOfFramesThatWasAskedForEachOnItsOwn) {
    const auto drops = drops_of(fault_of(Drop{.probability = 0.3, .burst_frames = 1}));
    EXPECT_NEAR(share_of(drops), 0.3, 0.01);
    EXPECT_NEAR(mean_run(drops), 1 / (1 - 0.3), 0.05) << "what chance alone makes";
}

TEST(Drop, InBurstsLosesTheSameShareInRunsOfTheLengthThatWasAskedFor) {
    const auto drops = drops_of(fault_of(Drop{.probability = 0.2, .burst_frames = 10}));
    EXPECT_NEAR(share_of(drops), 0.2, 0.03);
    EXPECT_NEAR(mean_run(drops), 10.0, 1.0);
}

TEST(Drop, IsTheChainThatItsDefinitionMakesStepByStep) {
    const FaultRef fault = fault_of(Drop{.probability = 0.25, .burst_frames = 5});
    const double stays_bad = 1 - 1.0 / 5, turns_bad = 0.25 / (5 * 0.75);
    bool is_bad = false;
    for (int i = 0; i < frames; ++i) {
        is_bad = chance(*fault, static_cast<std::uint64_t>(i)) < (is_bad ? stays_bad : turns_bad);
        ASSERT_EQ(is_dropped(at_frame(fault, i)), is_bad) << i;
    }
}

TEST(Drop, AFrameLostAtALowSeverityIsLostAtEveryHigherOne) {
    for (const double burst : {1.0, 8.0}) {
        std::vector<bool> milder(frames, false);
        double share = 0.0;
        for (const double severity : {0.1, 0.3, 0.5, 0.8, 1.0}) {
            const auto drops = drops_of(fault_of(Drop{.probability = 1.0, .burst_frames = burst}, severity));
            for (std::size_t i = 0; i < drops.size(); ++i) ASSERT_TRUE(drops[i] || !milder[i]) << severity << " " << i;
            EXPECT_GT(share_of(drops), share);
            share = share_of(drops);
            milder = drops;
        }
        EXPECT_EQ(share, 1.0);
    }
}

TEST(Drop, AnotherSeedLosesOtherFrames) {
    const Drop half{.probability = 0.5, .burst_frames = 1};
    EXPECT_EQ(drops_of(fault_of(half, 1.0, 7)), drops_of(fault_of(half, 1.0, 7)));
    EXPECT_NE(drops_of(fault_of(half, 1.0, 7)), drops_of(fault_of(half, 1.0, 8)));
}

TEST(ReducedRate, LeavesOutTheShareEvenlyAndMoreAtAHigherSeverity) {
    std::int64_t fewer = 0;
    for (const double severity : {0.25, 0.5, 0.75, 1.0}) {
        const auto drops = drops_of(fault_of(ReducedRate{.share = 0.8}, severity));
        EXPECT_NEAR(share_of(drops), 0.8 * severity, 1e-3);
        EXPECT_GT(std::ranges::count(drops, true), fewer);
        fewer = std::ranges::count(drops, true);
        for (std::size_t i = 0; i + 100 < drops.size(); i += 100) {
            const auto lost = std::count(drops.begin() + static_cast<std::ptrdiff_t>(i),
                                         drops.begin() + static_cast<std::ptrdiff_t>(i) + 100, true);
            ASSERT_NEAR(static_cast<double>(lost), 80 * severity, 1.0) << i;
        }
    }
    const auto all = drops_of(fault_of(ReducedRate{.share = 1.0}));
    EXPECT_EQ(share_of(all), 1.0);
}

/// For each frame from 0 on, whether it repeats what was seen.
std::vector<bool> repeats_of(const FaultRef& fault, int count) {
    std::vector<bool> repeats;
    TimeNs shown_ns = -1;  // what was seen before the fault began
    for (int i = 0; i < count; ++i) {
        const FrameFaults faults = at_frame(fault, i);
        repeats.push_back(is_repeat(faults, shown_ns));
        if (!repeats.back()) shown_ns = faults.frame.world_ns;
    }
    return repeats;
}

TEST(Freeze, ItsFirstFrameIsTheLastPictureOfItsOwn) {
    const auto repeats = repeats_of(fault_of(Freeze{}), 100);
    EXPECT_FALSE(repeats[0]);
    EXPECT_EQ(std::ranges::count(repeats, true), 99);
}

TEST(Freeze, BelowSeverity1ItStandsForThatShareOfEachPeriod) {
    const auto repeats = repeats_of(fault_of(Freeze{.period_s = 2.0}, 0.4), 100);
    for (int i = 0; i < 100; ++i) {
        const int in_period = i % 50;
        EXPECT_EQ(repeats[static_cast<std::size_t>(i)], in_period > 0 && in_period < 20) << i;
    }
}

TEST(Freeze, RepeatsMoreAtEveryHigherSeverity) {
    std::int64_t fewer = 0;
    for (const double severity : {0.2, 0.4, 0.6, 0.8, 1.0}) {
        const auto count = std::ranges::count(repeats_of(fault_of(Freeze{}, severity), 500), true);
        EXPECT_GT(count, fewer);
        fewer = count;
    }
}

TEST(Duplicate, RepeatsTheShareAskedForAndTheSameFramesAtHigherSeverity) {
    std::vector<bool> milder(frames, false);
    for (const double severity : {0.25, 0.5, 1.0}) {
        const auto repeats = repeats_of(fault_of(Duplicate{.probability = 0.8}, severity), frames);
        EXPECT_NEAR(share_of(repeats), 0.8 * severity, 0.015);
        for (std::size_t i = 0; i < repeats.size(); ++i) ASSERT_TRUE(repeats[i] || !milder[i]);
        milder = repeats;
    }
}

}  // namespace
}  // namespace camrig::fault
