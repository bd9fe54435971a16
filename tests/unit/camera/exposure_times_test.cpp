#include "core/camera/exposure_times.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace camrig::camera::exposure_times_test {
namespace {

Rate rate(const char* text) {
    return Rate::parse(text).value();
}

TEST(ExposureTimes, WithoutAClockTheyAreThoseOfTheRate) {
    for (const char* text : {"25", "30000/1001", "1/10", "1000"}) {
        const ExposureTimes times(rate(text)), right(rate(text), ClockSpec{.offset_ns = 5, .drift_ppb = 7});
        EXPECT_EQ(times, right);  // what a clock says moves no exposure
        for (std::int64_t n : {0, 1, 2, 3, 1'000'003}) EXPECT_EQ(times.time_of_frame(n), rate(text).time_of_frame(n));
    }
}

TEST(ExposureTimes, ARateErrorIsExactAlsoAfterYears) {
    const ExposureTimes times(rate("25"), ClockSpec{.rate_ppb = 100'000});
    EXPECT_EQ(times.time_of_frame(1), 39'996'000);            // 40 ms / 1.0001 = 39 996 000.399...
    EXPECT_EQ(times.time_of_frame(10'001), 400'000'000'000);  // 10001 / 25.0025 s = 400 s
    EXPECT_EQ(times.time_of_frame(std::int64_t{10'001} * 5'000'000), std::int64_t{400'000'000'000} * 5'000'000);
    const ExposureTimes slow(rate("30000/1001"), ClockSpec{.rate_ppb = -1'000'000});
    EXPECT_EQ(slow.time_of_frame(29'970), 1'001 * ns_per_s);  // 30000/1001 * 0.999
}

TEST(ExposureTimes, APhaseMovesAllOfThem) {
    const ExposureTimes times(rate("25"), ClockSpec{.phase_ns = 7'000'001});
    EXPECT_EQ(times.time_of_frame(0), 7'000'001);
    EXPECT_EQ(times.time_of_frame(10), 407'000'001);
    EXPECT_EQ(times.first_frame_at_or_after(0), 0);
    EXPECT_EQ(times.frames_until(7'000'000), 0);
    EXPECT_EQ(times.frames_until(7'000'001), 1);
}

TEST(ExposureTimes, TriggerJitterIsLateOnlyAndFillsItsRange) {
    const ExposureTimes even(rate("100")), late(rate("100"), ClockSpec{.trigger_jitter_ns = 2'000'000, .seed = 1});
    TimeNs most = 0, least = max_time_ns;
    for (std::int64_t n = 0; n < 2'000; ++n) {
        const TimeNs by = late.time_of_frame(n) - even.time_of_frame(n);
        most = std::max(most, by);
        least = std::min(least, by);
    }
    EXPECT_GE(least, 0);
    EXPECT_LT(least, 10'000);
    EXPECT_LE(most, 2'000'000);
    EXPECT_GT(most, 1'990'000);
}

TEST(ExposureTimes, RiseAndFindTheirFrameAgain) {
    const auto random = [](std::uint64_t i, std::uint64_t what, std::uint64_t most) {
        return static_cast<std::int64_t>(random_bits(3, what, i) % (most + 1));
    };
    for (std::uint64_t i = 0; i < 300; ++i) {
        const char* rates[] = {"25", "30000/1001", "1000", "0.1", "999999999/1000000000"};
        const ExposureTimes times(rate(rates[i % 5]), ClockSpec{.phase_ns = random(i, 0, ClockSpec::max_phase_ns),
                                                                .rate_ppb = random(i, 1, 2'000'000) - 1'000'000,
                                                                .trigger_jitter_ns = i % 3 ? random(i, 2, ns_per_s) : 0,
                                                                .seed = i});
        const std::int64_t first = i % 2 ? 0 : random(i, 3, 100'000'000);  // up to 30 years
        for (std::int64_t n = first; n < first + 50; ++n) {
            const TimeNs due = times.time_of_frame(n);
            if (due >= max_time_ns) break;
            ASSERT_EQ(times.first_frame_at_or_after(due), n) << i;
            ASSERT_EQ(times.first_frame_at_or_after(due + 1), n + 1) << i;
            ASSERT_EQ(times.frames_until(due), n + 1) << i;
            ASSERT_LT(due, times.time_of_frame(n + 1)) << i;
        }
    }
}

}  // namespace
}  // namespace camrig::camera::exposure_times_test
