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
    return damaged_video(fault::at_frame(fault::fault_of(how), 1), unit(slice_header), NalCodec::h264);
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
    EXPECT_EQ(damaged_video(fault::at_frame(fault::fault_of(fault::Stall{}), 1), unit(idr), NalCodec::h264), unit(idr));
}

}  // namespace
}  // namespace camrig::rtsp
