#include "core/base/random.h"

#include <gtest/gtest.h>

namespace camrig {
namespace {

// Known answers of Philox4x32-10 (Random123 distribution, kat_vectors): all-zero and all-one counter and key.
TEST(Random, MatchesThePublishedVectors) {
    EXPECT_EQ(static_cast<std::uint32_t>(random_bits(0, 0, 0)), 0x6627e8d5u);
    EXPECT_EQ(static_cast<std::uint32_t>(random_bits(0, 0, 0) >> 32), 0xe169c58du);
    EXPECT_EQ(static_cast<std::uint32_t>(random_bits(~0ull, ~0ull, ~0ull)), 0x408f276du);
    EXPECT_EQ(static_cast<std::uint32_t>(random_bits(~0ull, ~0ull, ~0ull) >> 32), 0x41c83b0eu);
}

TEST(Random, UnitNumbersAreUniformInTheirMeanAndStayBelowOne) {
    double sum = 0;
    for (std::uint64_t i = 0; i < 100000; ++i) {
        const double value = random_unit(7, 3, i);
        ASSERT_GE(value, 0.0);
        ASSERT_LT(value, 1.0);
        sum += value;
    }
    EXPECT_NEAR(sum / 100000, 0.5, 0.005);
}

}  // namespace
}  // namespace camrig
