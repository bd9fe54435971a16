#include "core/frame/damage.h"

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "core/frame/frame.h"

namespace camrig::frame::damage_test {
namespace {

/// The first 8 bands: '1' for those that are damaged.
std::string bands(const Damage& damage) {
    std::string text;
    for (int band = 0; band < 8; ++band) text += damage.contains_band(band) ? '1' : '0';
    return text;
}

Damage since(std::int64_t base, int first, int end) {
    Damage damage = Damage::since(base);
    damage.add(first, end);
    return damage;
}

TEST(Damage, IsEverywhereUntilThereIsABase) {
    EXPECT_EQ(bands({}), "11111111");
    EXPECT_EQ(bands(Damage::since(7)), "00000000");
    EXPECT_FALSE(Damage{}.base());
    EXPECT_EQ(Damage::since(7).base(), 7);
}

TEST(Damage, TakesEveryBandThatARowIsIn) {
    EXPECT_EQ(bands(since(1, 0, 1)), "10000000");
    EXPECT_EQ(bands(since(1, 15, 16)), "10000000");
    EXPECT_EQ(bands(since(1, 15, 17)), "11000000");
    EXPECT_EQ(bands(since(1, 16, 32)), "01000000");
    EXPECT_EQ(bands(since(1, 31, 65)), "01111000");
}

TEST(Damage, OfNoRowsIsNone) {
    EXPECT_EQ(bands(since(1, 0, 0)), "00000000");
    EXPECT_EQ(bands(since(1, 40, 40)), "00000000");
    EXPECT_EQ(bands(since(1, 40, 8)), "00000000");
}

TEST(Damage, OutsideOfThePictureDoesNoHarm) {
    EXPECT_EQ(bands(since(1, -100, -1)), "00000000");
    EXPECT_EQ(bands(since(1, -100, 1)), "10000000");
    EXPECT_EQ(bands(since(1, 100, std::numeric_limits<int>::max())), "00000011");
}

TEST(Damage, BeyondTheTallestCameraIsAlways) {
    EXPECT_FALSE(Damage::since(1).contains_band(Damage::max_bands - 1));
    EXPECT_TRUE(Damage::since(1).contains_band(Damage::max_bands));
}

TEST(Damage, BetweenTwoPicturesOfOneBaseIsThatOfBoth) {
    const Damage between = Damage::between(20, since(3, 0, 8), since(3, 64, 72));
    EXPECT_EQ(between.base(), 20);
    EXPECT_EQ(bands(between), "10001000");
    EXPECT_EQ(Damage::between(20, since(3, 0, 8), since(4, 64, 72)), Damage{}) << "of another base";
    EXPECT_EQ(Damage::between(20, {}, {}), Damage{}) << "nothing is known of either";
}

TEST(Damage, IsSinceTheFrameOfThatNumberCameraKindAndSizeOnly) {
    FrameInfo earlier;
    earlier.camera_id = CameraId{3};
    earlier.sequence = 20;
    earlier.size = {64, 48};
    FrameInfo info = earlier;
    info.sequence = 21;
    EXPECT_FALSE(is_damage_since(earlier, info)) << "not known";
    info.damage = Damage::since(20);
    EXPECT_TRUE(is_damage_since(earlier, info));
    const auto but = [&](auto change) {
        FrameInfo other = earlier;
        change(other);
        return is_damage_since(other, info);
    };
    EXPECT_FALSE(but([](FrameInfo& other) { other.sequence = 19; }));
    EXPECT_FALSE(but([](FrameInfo& other) { other.camera_id = CameraId{4}; }));
    EXPECT_FALSE(but([](FrameInfo& other) { other.kind = FrameKind::depth; }));
    EXPECT_FALSE(but([](FrameInfo& other) { other.size = {64, 47}; }));
}

}  // namespace
}  // namespace camrig::frame::damage_test
