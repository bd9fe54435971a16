#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace camrig::rtsp {

/// Whose NAL units: their headers differ.
enum class NalCodec : std::uint8_t { h264, h265 };

/// A NAL unit's place in a byte stream (ITU-T H.264 and H.265, Annex B).
struct Nal {
    std::size_t begin = 0;  ///< of its start code, with the zero byte that may come before it
    std::size_t header = 0;
    std::size_t end = 0;
    std::uint8_t first_byte = 0;  ///< of the header, which has one byte in H.264 and two in H.265

    /// H.264, table 7-1; H.265, table 7-1, where SEI that comes before the slices is a type of its own.
    static constexpr std::uint8_t h264_sei = 6, h265_prefix_sei = 39;
    std::uint8_t type(NalCodec codec) const {
        return codec == NalCodec::h264 ? first_byte & 0x1f : (first_byte >> 1) & 0x3f;
    }
    bool is_slice(NalCodec codec) const {
        return codec == NalCodec::h264 ? type(codec) >= 1 && type(codec) <= 5 : type(codec) < 32;
    }
};

/// The NAL unit whose start code is the first at or after `from`.
inline std::optional<Nal> next_nal(std::span<const std::byte> data, std::size_t from) {
    constexpr std::array code = {std::byte{0}, std::byte{0}, std::byte{1}};
    const auto find_code = [&](std::size_t at) {
        const auto found =
            std::search(data.begin() + static_cast<std::ptrdiff_t>(at), data.end(), code.begin(), code.end());
        return static_cast<std::size_t>(found - data.begin());
    };
    const std::size_t at = find_code(std::min(from, data.size()));
    if (at + code.size() >= data.size()) return std::nullopt;
    Nal nal;
    nal.begin = at > from && data[at - 1] == std::byte{0} ? at - 1 : at;
    nal.header = at + code.size();
    nal.end = find_code(nal.header);
    nal.first_byte = std::to_integer<std::uint8_t>(data[nal.header]);
    return nal;
}

/// How much of an access unit of H.265 is to be left out at its begin. The first of an encoder may have parameter sets
/// twice: x265enc (GStreamer 1.22) takes more of x265's header than there is, so that its picture parameter set ends
/// with bytes of memory that were never written, which may look like slices too. x265 (repeat-headers) sends its own
/// behind them, each from a video parameter set on.
inline std::size_t begin_of_last_parameter_sets(std::span<const std::byte> access_unit) {
    constexpr std::uint8_t video_parameter_set = 32;
    std::size_t begin = 0;
    for (auto nal = next_nal(access_unit, 0); nal; nal = next_nal(access_unit, nal->end))
        if (nal->type(NalCodec::h265) == video_parameter_set) begin = nal->begin;
    return begin;
}

}  // namespace camrig::rtsp
