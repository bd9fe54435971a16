#include "core/daylight/clouds.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "core/base/digest.h"

namespace camrig::daylight {
namespace {

/// By solid angle, from the lowest row with clouds up.
double hidden_share(const Clouds& clouds) {
    double hidden = 0.0, whole = 0.0;
    for (int row = Clouds::lowest_row(); row < Clouds::rows; ++row) {
        const double weight = std::cos(Clouds::elevation_of(row)) * (row + 0.5);
        for (const CloudSight& sight : clouds.row(row)) hidden += weight * sight.opacity / 255.0;
        whole += weight * Clouds::columns;
    }
    return hidden / whole;
}
/// Of opacity, between a column and the next.
double mean_step(const Clouds& clouds, int column) {
    double sum = 0.0;
    for (int row = 0; row < Clouds::rows; ++row) {
        const auto line = clouds.row(row);
        const auto here = static_cast<std::size_t>(column), next = static_cast<std::size_t>(column + 1) % line.size();
        sum += std::abs(line[here].opacity - line[next].opacity);
    }
    return sum / Clouds::rows;
}

TEST(Clouds, HideTheShareOfTheSkyThatIsAskedFor) {
    for (const double share : {0.02, 0.1, 0.25, 0.4, 0.6, 0.85, 0.98})
        EXPECT_NEAR(hidden_share(Clouds(share)), share, 0.02) << share;
}

TEST(Clouds, AreSoftAtTheirEdgesAndClosedInTheirMiddles) {
    const Clouds clouds(0.35);
    std::array<int, 3> count{};
    for (int row = Clouds::lowest_row(); row < Clouds::rows; ++row)
        for (const CloudSight& sight : clouds.row(row)) ++count[sight.opacity == 0 ? 0 : sight.opacity < 230 ? 1 : 2];
    const double all = count[0] + count[1] + count[2];
    EXPECT_GT(count[0] / all, 0.4);
    EXPECT_GT(count[1] / all, 0.03);
    EXPECT_GT(count[2] / all, 0.15);
}

TEST(Clouds, HaveNoSeamWhereTheSkyBeginsAnew) {
    const Clouds clouds(0.4);
    double most = 0.0;
    for (int column = 0; column < Clouds::columns - 1; ++column) most = std::max(most, mean_step(clouds, column));
    EXPECT_GT(most, 0.5);
    EXPECT_LE(mean_step(clouds, Clouds::columns - 1), most);
}

TEST(Clouds, LookDownAtTheirBasesAndUpOverThem) {
    const Clouds clouds(0.35);
    double low = 0.0, high = 0.0;
    int low_count = 0, high_count = 0;
    for (int row = Clouds::lowest_row(); row < Clouds::rows; ++row)
        for (const CloudSight& sight : clouds.row(row)) {
            const bool is_base = sight.opacity > 0 && sight.height < 20, is_top = sight.height > 200;
            low += is_base ? sight.outward[2] : 0;
            low_count += is_base;
            high += is_top ? sight.outward[2] : 0;
            high_count += is_top;
        }
    EXPECT_LT(low / low_count, -30.0);
    EXPECT_GT(high / high_count, 60.0);
    for (int row = 0; row < Clouds::lowest_row(); ++row)
        EXPECT_TRUE(std::ranges::all_of(clouds.row(row), [](const CloudSight& one) { return one.opacity == 0; }));
}

TEST(Clouds, AreTheSameBytesOnEveryMachine) {
    Digest digest;
    const Clouds clouds(0.3);
    for (int row = 0; row < Clouds::rows; ++row)
        for (const CloudSight& one : clouds.row(row))
            digest.add(one.opacity, one.outward[0], one.outward[1], one.outward[2], one.height, one.depth);
    EXPECT_EQ(digest.value(), 12152429698321401577u);
}

TEST(Clouds, AreKeptUntilAnotherShareIsAskedFor) {
    const auto first = clouds_of(0.2);
    EXPECT_EQ(clouds_of(0.2), first);
    EXPECT_NE(clouds_of(0.3), first);
}

}  // namespace
}  // namespace camrig::daylight
