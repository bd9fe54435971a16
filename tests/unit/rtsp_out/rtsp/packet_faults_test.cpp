#include "rtsp_out/rtsp/packet_faults.h"

#include <array>

#include <gtest/gtest.h>

#include "tests/unit/fault/faulty.h"

namespace camrig::rtsp {
namespace {

/// An RTP packet, the last of its picture (RFC 3550, 5.1).
GstBufferHandle numbered_packet(guint8 number) {
    const std::array<guint8, 13> bytes{0x80, 0x80 | 96, 0, number};
    return GstBufferHandle(gst_buffer_new_memdup(bytes.data(), bytes.size()));
}

std::vector<int> numbers_of(const std::vector<GstBufferHandle>& packets) {
    std::vector<int> numbers;
    for (const GstBufferHandle& packet : packets) {
        std::array<guint8, 4> head{};
        gst_buffer_extract(packet.get(), 0, head.data(), head.size());
        numbers.push_back(head[3]);
    }
    return numbers;
}

TEST(PacketFaults, WhatIsDelayedComesBeforeThePicturesOfAWorldThatIsLoaded) {
    gst_init(nullptr, nullptr);
    const auto delay = fault::fault_of(fault::PacketDelay{.probability = 1.0, .delay_s = 0.1});
    PacketFaults faults;
    std::vector<GstBufferHandle> sent;
    const auto pass = [&](guint8 number, std::int64_t sequence) {
        const fault::FrameFaults at = fault::at_frame(delay, sequence);
        faults.pass(numbered_packet(number), &at, sent);
        return numbers_of(sent);
    };
    EXPECT_EQ(pass(1, 2500), std::vector<int>());  // at 100 s
    EXPECT_EQ(pass(2, 0), std::vector<int>({1}));
    EXPECT_EQ(pass(3, 2), std::vector<int>({1}));
    EXPECT_EQ(pass(4, 3), std::vector<int>({1, 2}));
}

}  // namespace
}  // namespace camrig::rtsp
