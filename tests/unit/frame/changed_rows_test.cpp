#include "core/frame/changed_rows.h"

#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace camrig {
namespace {

/// The first 8 bands: '1' for those that changed.
std::string bands(const ChangedRows& rows) {
    std::string text;
    for (int band = 0; band < 8; ++band) text += rows.contains_band(band) ? '1' : '0';
    return text;
}

ChangedRows rows(int first, int end) {
    ChangedRows changed;
    changed.add(first, end);
    return changed;
}

TEST(ChangedRows, StartWithout) {
    EXPECT_EQ(bands({}), "00000000");
}

TEST(ChangedRows, TakeEveryBandThatARowIsIn) {
    EXPECT_EQ(bands(rows(0, 1)), "10000000");
    EXPECT_EQ(bands(rows(15, 16)), "10000000");
    EXPECT_EQ(bands(rows(15, 17)), "11000000");
    EXPECT_EQ(bands(rows(16, 32)), "01000000");
    EXPECT_EQ(bands(rows(31, 65)), "01111000");
}

TEST(ChangedRows, OfNoRowsAreNone) {
    EXPECT_EQ(bands(rows(0, 0)), "00000000");
    EXPECT_EQ(bands(rows(40, 40)), "00000000");
    EXPECT_EQ(bands(rows(40, 8)), "00000000");
}

TEST(ChangedRows, OutsideOfThePictureDoNoHarm) {
    EXPECT_EQ(bands(rows(-100, -1)), "00000000");
    EXPECT_EQ(bands(rows(-100, 1)), "10000000");
    EXPECT_EQ(bands(rows(100, std::numeric_limits<int>::max())), "00000011");
}

TEST(ChangedRows, JoinAndClear) {
    ChangedRows both = rows(0, 8);
    both |= rows(64, 72);
    EXPECT_EQ(bands(both), "10001000");
    both.clear();
    EXPECT_EQ(both, ChangedRows{});
}

TEST(ChangedRows, BeyondTheTallestCameraAreChangedAlways) {
    EXPECT_FALSE(ChangedRows{}.contains_band(ChangedRows::max_bands - 1));
    EXPECT_TRUE(ChangedRows{}.contains_band(ChangedRows::max_bands));
}

}  // namespace
}  // namespace camrig
