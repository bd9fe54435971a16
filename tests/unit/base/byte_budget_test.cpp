#include "core/base/byte_budget.h"

#include <optional>

#include <gtest/gtest.h>

namespace camrig {
namespace {

TEST(ByteBudget, WhatIsNotThereIsRefusedWithItsAdviceAndTakesNothing) {
    const auto budget = ByteBudget::create(10, "ask again");
    auto claim = budget->claim(7);
    ASSERT_TRUE(claim);
    const auto refused = budget->claim(4);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::resource_exhausted);
    EXPECT_EQ(refused.error().message, "ask again");
    EXPECT_EQ(budget->used(), 7u);
    EXPECT_TRUE(budget->claim(3));
    EXPECT_FALSE(budget->claim(~std::size_t{0}));
}

TEST(ByteBudget, AClaimGivesBackWhatItDoesNotNeedAndAllOfItAtItsEnd) {
    const auto budget = ByteBudget::create(10, "");
    {
        ByteBudget::Claim claim = budget->claim(10).value();
        claim.shrink_to(4);
        claim.shrink_to(6);
        EXPECT_EQ(budget->used(), 4u);
        const ByteBudget::Claim moved = std::move(claim);
        EXPECT_EQ(budget->used(), 4u);
    }
    EXPECT_EQ(budget->used(), 0u);
}

TEST(ByteBudget, AShareCountsInTheWholeAndIsRefusedByEither) {
    const auto whole = ByteBudget::create(10, "whole");
    const auto one = ByteBudget::create(8, "share", whole), other = ByteBudget::create(8, "share", whole);
    auto claim = std::optional(one->claim(8).value());
    EXPECT_EQ(one->claim(1).error().message, "share");
    EXPECT_EQ(other->claim(3).error().message, "whole");
    EXPECT_EQ(other->used(), 0u);
    claim.reset();
    EXPECT_EQ(whole->used(), 0u);
    EXPECT_TRUE(other->claim(8));
}

}  // namespace
}  // namespace camrig
