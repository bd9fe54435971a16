#include "rtsp_out/rtsp/damaged_video.h"

#include <gtest/gtest.h>

#include "tests/unit/fault/faulty.h"

namespace camrig::rtsp {
namespace {

/// A parameter set and two slices of 100 bytes, of that NAL header.
std::vector<std::byte> unit(int slice_header) {
    std::vector<std::byte> out;
    for (const int value : {0, 0, 0, 1, 0x67, 1, 2, 3}) out.push_back(std::byte(value));
    for (int slice = 0; slice < 2; ++slice) {
        for (const int value : {0, 0, 1, slice_header}) out.push_back(std::byte(value));
        out.insert(out.end(), 100, std::byte{0x55});
    }
    return out;
}

std::vector<std::byte> damaged(const fault::CorruptVideo& how, int slice_header) {
    return damaged_video(fault::at_frame(fault::fault_of(how), 1), unit(slice_header), NalCodec::h264).bytes;
}

constexpr int idr = 0x65, other = 0x41;

TEST(DamagedVideo, LeavesHeadersAndLengthWhereBitsFlip) {
    const auto after = damaged({.amount = 50, .probability = 1.0}, idr), before = unit(idr);
    ASSERT_EQ(after.size(), before.size());
    EXPECT_NE(after, before);
    for (const std::size_t begin : {std::size_t{0}, std::size_t{8}, std::size_t{112}})
        EXPECT_TRUE(std::equal(&after[begin], &after[begin] + 8, &before[begin])) << begin;
}

TEST(DamagedVideo, LeavesOutSlicesOrThoseOfKeyFrames) {
    EXPECT_EQ(damaged({.mode = fault::VideoDamage::drop_nal, .probability = 1.0}, other).size(), 8U);
    EXPECT_EQ(damaged({.mode = fault::VideoDamage::drop_idr, .probability = 1.0}, idr).size(), 8U);
    EXPECT_EQ(damaged({.mode = fault::VideoDamage::drop_idr, .probability = 1.0}, other), unit(other));
}

TEST(DamagedVideo, LeavesTheBytesOfOtherFaults) {
    const auto sent = damaged_video(fault::at_frame(fault::fault_of(fault::Stall{}), 1), unit(idr), NalCodec::h264);
    EXPECT_EQ(sent.bytes, unit(idr));
    EXPECT_TRUE(sent.harms.empty());
}

TEST(DamagedVideo, SaysWhichBytesOfTheAccessUnitAreWrongOrMissing) {
    const auto before = unit(idr);
    const auto frame = [](const fault::CorruptVideo& how) { return fault::at_frame(fault::fault_of(how), 1); };
    const auto flipped = damaged_video(frame({.mode = fault::VideoDamage::bitflip, .amount = 9, .probability = 1.0}),
                                       before, NalCodec::h264);
    ASSERT_EQ(flipped.harms.size(), 1U) << "of both slices";
    std::vector<std::byte> healed = flipped.bytes;
    for (const fault::Harm::Run& run : flipped.harms[0].first)
        std::copy_n(&before[run.offset], run.bytes, &healed[run.offset]);
    EXPECT_EQ(healed, before);
    EXPECT_GT(flipped.harms[0].bytes, 9U);
    const auto dropped =
        damaged_video(frame({.mode = fault::VideoDamage::drop_nal, .probability = 1.0}), before, NalCodec::h264);
    EXPECT_EQ(dropped.harms[0].first, std::vector({fault::Harm::Run{8, 208}}));
    EXPECT_EQ(dropped.harms[0].size, before.size());
}

}  // namespace
}  // namespace camrig::rtsp
