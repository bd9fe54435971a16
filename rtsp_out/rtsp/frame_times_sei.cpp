#include "rtsp_out/rtsp/frame_times_sei.h"

namespace camrig::rtsp {
namespace {

constexpr std::uint8_t sei_user_data_unregistered = 5;
constexpr std::size_t message_bytes = frame_times_uuid.size() + 4 * sizeof(std::int64_t);

void put_number(std::vector<std::byte>& out, std::int64_t value) {
    for (int shift = 56; shift >= 0; shift -= 8)
        out.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> shift));
}

/// Appends payload bytes to a NAL unit; 00 00 0x (x < 4) becomes 00 00 03 0x (H.264 and H.265, 7.4.1 and 7.4.2).
void put_escaped(std::vector<std::byte>& out, std::span<const std::byte> payload) {
    int zeros = 0;
    for (const std::byte byte : payload) {
        if (zeros == 2 && std::to_integer<int>(byte) <= 3) {
            out.push_back(std::byte{3});
            zeros = 0;
        }
        out.push_back(byte);
        zeros = byte == std::byte{0} ? zeros + 1 : 0;
    }
}

std::vector<std::byte> sei_nal(const FrameTimes& times, NalCodec codec) {
    std::vector<std::byte> payload;
    payload.push_back(std::byte{sei_user_data_unregistered});
    payload.push_back(static_cast<std::byte>(message_bytes));
    for (const std::uint8_t byte : frame_times_uuid) payload.push_back(std::byte{byte});
    for (const std::int64_t value : {times.sequence, times.world_ns, times.monotonic_ns, times.realtime_ns})
        put_number(payload, value);
    payload.push_back(std::byte{0x80});  // the stop bit
    std::vector<std::byte> nal = {std::byte{0}, std::byte{0}, std::byte{0}, std::byte{1}};
    if (codec == NalCodec::h264) {
        nal.push_back(std::byte{Nal::h264_sei});
    } else {  // layer 0, temporal id 0 (plus one)
        nal.push_back(std::byte{Nal::h265_prefix_sei << 1});
        nal.push_back(std::byte{1});
    }
    put_escaped(nal, payload);
    return nal;
}

}  // namespace

std::vector<std::byte> with_frame_times(std::span<const std::byte> access_unit, const FrameTimes& times,
                                        NalCodec codec) {
    std::vector<std::byte> out;
    std::size_t at = 0;
    for (auto nal = next_nal(access_unit, 0); nal; nal = next_nal(access_unit, nal->end)) {
        if (!nal->is_slice(codec)) continue;
        const auto message = sei_nal(times, codec);
        out.reserve(access_unit.size() + message.size());
        const auto middle = access_unit.begin() + static_cast<std::ptrdiff_t>(nal->begin);
        out.assign(access_unit.begin(), middle);
        out.insert(out.end(), message.begin(), message.end());
        at = nal->begin;
        break;
    }
    out.insert(out.end(), access_unit.begin() + static_cast<std::ptrdiff_t>(at), access_unit.end());
    return out;
}

}  // namespace camrig::rtsp
