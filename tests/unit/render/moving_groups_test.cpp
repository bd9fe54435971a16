#include "core/render/moving_groups.h"

#include <algorithm>

#include <gmock/gmock.h>

namespace camrig::render {
namespace {

using testing::ElementsAre;

constexpr ObjectId anna{1}, ben{2}, car{3};

TEST(MovingGroups, WhatMovesLittleIsDrawnAtFewMoments) {
    const auto groups =
        moving_groups({{anna, 9.0, {0, 0, 10, 10}}, {ben, 1.5, {20, 0, 30, 10}}, {car, 0.0, {40, 0, 50, 10}}});
    ASSERT_EQ(groups.size(), 3u);
    EXPECT_THAT(groups[0].movers, ElementsAre(car));
    EXPECT_EQ(groups[0].moved_px, 0.0);
    EXPECT_THAT(groups[1].movers, ElementsAre(ben));
    EXPECT_EQ(groups[1].moved_px, 1.5);
    EXPECT_THAT(groups[2].movers, ElementsAre(anna));
    EXPECT_EQ(groups[2].moved_px, 9.0);
}

TEST(MovingGroups, WhatIsBeforeEachOtherIsDrawnTogether) {
    // The car reaches over both people.
    const auto groups =
        moving_groups({{anna, 9.0, {0, 0, 10, 10}}, {ben, 1.0, {20, 0, 30, 10}}, {car, 2.0, {5, 5, 25, 15}}});
    ASSERT_EQ(groups.size(), 1u);
    EXPECT_THAT(groups[0].movers, ElementsAre(anna, ben, car));
    EXPECT_EQ(groups[0].moved_px, 9.0);
}

TEST(MovingGroups, WaysThatAreAboutAsFarShareTheirMoments) {
    const auto groups =
        moving_groups({{anna, 4.1, {0, 0, 10, 10}}, {ben, 6.0, {20, 0, 30, 10}}, {car, 6.1, {40, 0, 50, 10}}});
    ASSERT_EQ(groups.size(), 2u);
    EXPECT_THAT(groups[0].movers, ElementsAre(anna, ben));
    EXPECT_EQ(groups[0].moved_px, 6.0);
    EXPECT_THAT(groups[1].movers, ElementsAre(car));
}

TEST(MovingGroups, AreTheSameForWaysInAnyOrder) {
    std::vector<MoverWay> ways{{anna, 3.0, {0, 0, 10, 10}}, {ben, 1.0, {9, 9, 12, 12}}, {car, 8.0, {20, 0, 30, 10}}};
    const auto in_order = moving_groups(ways);
    std::ranges::reverse(ways);
    const auto reversed = moving_groups(ways);
    ASSERT_EQ(in_order.size(), reversed.size());
    for (std::size_t i = 0; i < in_order.size(); ++i) {
        EXPECT_EQ(in_order[i].movers, reversed[i].movers);
        EXPECT_EQ(in_order[i].moved_px, reversed[i].moved_px);
    }
}

}  // namespace
}  // namespace camrig::render
