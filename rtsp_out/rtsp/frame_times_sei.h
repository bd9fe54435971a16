#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/time.h"
#include "rtsp_out/rtsp/annex_b.h"

namespace camrig::rtsp {

/// Which frame a picture of an H.264 or H.265 stream is, and the instant that it shows.
struct FrameTimes {
    std::int64_t sequence = 0;
    TimeNs world_ns = 0;
    TimeNs monotonic_ns = 0;
    TimeNs realtime_ns = 0;  ///< of the same instant, since 1970
    friend bool operator==(const FrameTimes&, const FrameTimes&) = default;
};

/// Names our message among user_data_unregistered SEI messages (ITU-T H.264, D.1.7; H.265, D.2.7):
/// 7353d587-fbca-489f-8f46-ebe016b7c52e. After it come the four numbers of FrameTimes in that order, each 8 bytes,
/// two's complement, most significant first.
inline constexpr std::array<std::uint8_t, 16> frame_times_uuid = {0x73, 0x53, 0xd5, 0x87, 0xfb, 0xca, 0x48, 0x9f,
                                                                  0x8f, 0x46, 0xeb, 0xe0, 0x16, 0xb7, 0xc5, 0x2e};

/// The access unit (Annex B byte stream) with the message put before its first slice, where SEI has to be. One without
/// a slice is given back as it is.
std::vector<std::byte> with_frame_times(std::span<const std::byte> access_unit, const FrameTimes& times,
                                        NalCodec codec = NalCodec::h264);

}  // namespace camrig::rtsp
