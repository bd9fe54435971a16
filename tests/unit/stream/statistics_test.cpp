#include "core/stream/statistics.h"

#include <gtest/gtest.h>

namespace camrig::stream {
namespace {

TEST(StageTimer, QuantilesOfDurationsThatAreSpreadEvenlyAreExactToAHundredth) {
    StageTimer timer;
    for (int i = 1; i <= 1000; ++i) timer.record(i * ns_per_us);
    const auto summary = timer.summary();
    EXPECT_EQ(summary.count, 1000u);
    EXPECT_NEAR(summary.mean_ms, 0.5005, 1e-9);
    EXPECT_NEAR(summary.p50_ms, 0.5, 0.5 * 0.01);
    EXPECT_NEAR(summary.p99_ms, 0.99, 0.99 * 0.01);
    EXPECT_DOUBLE_EQ(summary.max_ms, 1.0);
}

TEST(StageTimer, HugeAndNegativeDurationsAreTaken) {
    StageTimer timer;
    timer.record(-5);
    timer.record(max_time_ns);
    EXPECT_EQ(timer.summary().count, 2u);
}

}  // namespace
}  // namespace camrig::stream
