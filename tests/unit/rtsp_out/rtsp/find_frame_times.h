#pragma once

#include "rtsp_out/rtsp/annex_b.h"
#include "rtsp_out/rtsp/frame_times_sei.h"

// Reads what with_frame_times() writes, as a client does.
namespace camrig::rtsp {

inline std::int64_t number_at(std::span<const std::byte> data, std::size_t at) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < 8; ++i) value = value << 8 | std::to_integer<std::uint64_t>(data[at + i]);
    return static_cast<std::int64_t>(value);
}

/// Without emulation prevention (H.264, 7.4.1).
inline std::vector<std::byte> unescaped(std::span<const std::byte> payload) {
    std::vector<std::byte> out;
    out.reserve(payload.size());
    int zeros = 0;
    for (const std::byte byte : payload) {
        if (zeros == 2 && byte == std::byte{3}) {
            zeros = 0;
            continue;
        }
        out.push_back(byte);
        zeros = byte == std::byte{0} ? std::min(zeros + 1, 2) : 0;
    }
    return out;
}

/// Walks the messages of an SEI NAL unit's payload (H.264, 7.3.2.3.1).
inline std::optional<FrameTimes> message_in(std::span<const std::byte> sei) {
    std::size_t at = 0;
    const auto coded = [&]() -> std::size_t {
        std::size_t value = 0;
        while (at < sei.size() && sei[at] == std::byte{0xff}) {
            value += 0xff;
            ++at;
        }
        return at < sei.size() ? value + std::to_integer<std::size_t>(sei[at++]) : value;
    };
    while (at + 2 <= sei.size()) {
        const std::size_t type = coded();
        const std::size_t size = coded();
        if (size > sei.size() - at) return std::nullopt;
        const auto body = sei.subspan(at, size);
        at += size;
        if (type != 5 /* user_data_unregistered */ || size != (frame_times_uuid.size() + 4 * sizeof(std::int64_t)))
            continue;
        if (!std::ranges::equal(body.first(frame_times_uuid.size()), frame_times_uuid, {},
                                [](std::byte byte) { return std::to_integer<std::uint8_t>(byte); }))
            continue;
        constexpr std::size_t first = frame_times_uuid.size();
        return FrameTimes{number_at(body, first), number_at(body, first + 8), number_at(body, first + 16),
                          number_at(body, first + 24)};
    }
    return std::nullopt;
}

/// The message of an access unit, if it has one. Reads any bytes.
inline std::optional<FrameTimes> find_frame_times(std::span<const std::byte> access_unit,
                                                  NalCodec codec = NalCodec::h264) {
    const std::size_t header_bytes = codec == NalCodec::h264 ? 1 : 2;
    for (auto nal = next_nal(access_unit, 0); nal; nal = next_nal(access_unit, nal->end)) {
        if (nal->is_slice(codec)) return std::nullopt;
        if (nal->type(codec) != (codec == NalCodec::h264 ? Nal::h264_sei : Nal::h265_prefix_sei)) continue;
        const auto payload = unescaped(access_unit.subspan(std::min(nal->header + header_bytes, nal->end),
                                                           nal->end - std::min(nal->header + header_bytes, nal->end)));
        if (auto found = message_in(payload)) return found;
    }
    return std::nullopt;
}

}  // namespace camrig::rtsp
