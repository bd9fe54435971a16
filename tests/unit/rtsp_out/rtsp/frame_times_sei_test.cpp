#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/rtsp_out/rtsp/find_frame_times.h"

namespace camrig::rtsp {
namespace {

std::vector<std::byte> bytes(std::initializer_list<int> values) {
    std::vector<std::byte> out;
    for (const int value : values) out.push_back(static_cast<std::byte>(value));
    return out;
}

/// Delimiter, parameter sets, another SEI message, a slice.
std::vector<std::byte> key_frame() {
    return bytes({0, 0, 0, 1, 9, 0x10, 0,    0,    0,    1, 0x67, 1, 2,    3, 0, 0, 0, 1, 0x68, 4,    5,
                  0, 0, 1, 6, 5, 2,    0xaa, 0xbb, 0x80, 0, 0,    1, 0x65, 7, 8, 9, 0, 0, 1,    0x65, 10});
}

TEST(FrameTimesSei, WhatIsPutInIsFoundAgain) {
    const FrameTimes times{1234, 5'000'000'000, 77'123'456'789, 1'790'000'000'000'000'001};
    EXPECT_EQ(find_frame_times(with_frame_times(key_frame(), times)), times);
    EXPECT_EQ(find_frame_times(key_frame()), std::nullopt);
}

TEST(FrameTimesSei, ItStandsBeforeTheFirstSliceAndAfterTheParameterSets) {
    const auto unit = with_frame_times(key_frame(), {1, 2, 3, 4});
    const auto before = key_frame();
    const std::size_t slice = 30;  // where the first slice's start code was
    ASSERT_GT(unit.size(), before.size());
    EXPECT_TRUE(std::equal(before.begin(), before.begin() + slice, unit.begin()));
    EXPECT_EQ(unit[slice + 4], std::byte{6});  // NAL type SEI
    EXPECT_TRUE(
        std::equal(before.begin() + slice, before.end(), unit.end() - static_cast<long>(before.size() - slice)));
}

TEST(FrameTimesSei, OfH265ItIsASeiUnitBeforeTheFirstSliceToo) {
    // VPS, SPS, PPS (32, 33, 34), an IDR slice (19).
    const auto before =
        bytes({0, 0, 0, 1, 0x40, 1, 7, 0, 0, 0, 1, 0x42, 1, 8, 0, 0, 0, 1, 0x44, 1, 9, 0, 0, 1, 0x26, 1, 5});
    const FrameTimes times{1234, 0, 77'123'456'789, 1'790'000'000'000'000'001};
    const auto unit = with_frame_times(before, times, NalCodec::h265);
    EXPECT_EQ(find_frame_times(unit, NalCodec::h265), times);
    EXPECT_EQ(find_frame_times(before, NalCodec::h265), std::nullopt);
    const std::size_t slice = 21;
    EXPECT_TRUE(std::equal(before.begin(), before.begin() + slice, unit.begin()));
    EXPECT_EQ(unit[slice + 4], std::byte{0x4e});  // type 39
    EXPECT_EQ(unit[slice + 5], std::byte{1});
    EXPECT_TRUE(
        std::equal(before.begin() + slice, before.end(), unit.end() - static_cast<long>(before.size() - slice)));
}

TEST(FrameTimesSei, NoStartCodeEverAppearsInsideTheMessage) {
    constexpr auto least = std::numeric_limits<std::int64_t>::min();
    const auto slice = bytes({0, 0, 0, 1, 0x41, 1});
    for (const FrameTimes& times : {FrameTimes{0, 0, 0, 0}, FrameTimes{1, 0x0000010000020000, 0x0000000300000003, 3},
                                    FrameTimes{least, -1, 256, 0x00000001000000}}) {
        const auto unit = with_frame_times(slice, times);
        EXPECT_EQ(find_frame_times(unit), times);
        int codes = 0;
        for (std::size_t i = 0; i + 2 < unit.size(); ++i) {
            const bool zeros = unit[i] == std::byte{0} && unit[i + 1] == std::byte{0};
            EXPECT_FALSE(zeros && unit[i + 2] == std::byte{2});
            codes += zeros && unit[i + 2] == std::byte{1};
        }
        EXPECT_EQ(codes, 2);  // the message's and the slice's
    }
}

TEST(FrameTimesSei, AnAccessUnitWithoutASliceStaysAsItIs) {
    const auto unit = bytes({0, 0, 0, 1, 0x67, 1, 2, 3});
    EXPECT_EQ(with_frame_times(unit, {1, 2, 3, 4}), unit);
    EXPECT_TRUE(with_frame_times({}, {1, 2, 3, 4}).empty());
}

TEST(ParameterSets, OfThoseBeforeAPictureTheLastAreLeft) {
    const auto own =
        bytes({0, 0, 0, 1, 0x40, 1, 7, 0, 0, 0, 1, 0x42, 1, 8, 0, 0, 0, 1, 0x44, 1, 9, 0, 0, 1, 0x26, 1, 5});
    EXPECT_EQ(begin_of_last_parameter_sets(own), 0u);
    // Sets whose last has anything behind it: a slice, another set.
    auto unit = bytes({0, 0,    0, 1, 0x40, 1, 7, 0, 0, 0, 1, 0x42, 1, 8,    0, 0, 0,
                       1, 0x44, 1, 9, 0xa5, 0, 0, 1, 0, 1, 0, 0,    1, 0x40, 1, 3, 0xa5});
    const std::size_t head = unit.size();
    unit.insert(unit.end(), own.begin(), own.end());
    // The zero before a start code may be what ends before it.
    EXPECT_EQ(begin_of_last_parameter_sets(unit), head + 1);
    EXPECT_EQ(begin_of_last_parameter_sets(bytes({0, 0, 0, 1, 2, 1, 5, 0, 0, 1, 2, 1, 6})), 0u);
    EXPECT_EQ(begin_of_last_parameter_sets({}), 0u);
}

TEST(FrameTimesSei, AnyBytesCanBeRead) {
    std::mt19937 random(3);
    for (int round = 0; round < 3000; ++round) {
        auto unit = with_frame_times(key_frame(), {round, 2, 3, 4});
        for (int i = 0; i < 4; ++i) unit[random() % unit.size()] = static_cast<std::byte>(random() % 4);
        unit.resize(random() % (unit.size() + 1));
        std::ignore = find_frame_times(unit);
        std::ignore = with_frame_times(unit, {1, 2, 3, 4});
    }
}

}  // namespace
}  // namespace camrig::rtsp
