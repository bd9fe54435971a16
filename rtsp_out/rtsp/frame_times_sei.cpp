#include "rtsp_out/rtsp/frame_times_sei.h"

#include <algorithm>

namespace camrig {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::uint8_t nal_sei = 6;
constexpr std::uint8_t nal_first_slice = 1;
constexpr std::uint8_t nal_last_slice = 5;
constexpr std::uint8_t sei_user_data_unregistered = 5;
constexpr std::size_t message_bytes = frame_times_uuid.size() + 4 * sizeof(std::int64_t);

struct Nal {
    std::size_t begin = 0;  ///< of its start code, with the zero byte that may come before it
    std::size_t header = 0;
    std::size_t end = 0;
    std::uint8_t type = 0;
};

/// The NAL unit whose start code is the first at or after `from`.
std::optional<Nal> next_nal(Bytes data, std::size_t from) {
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
    nal.type = std::to_integer<std::uint8_t>(data[nal.header]) & 0x1f;
    return nal;
}

bool is_slice(const Nal& nal) {
    return nal.type >= nal_first_slice && nal.type <= nal_last_slice;
}

void put_number(std::vector<std::byte>& out, std::int64_t value) {
    for (int shift = 56; shift >= 0; shift -= 8)
        out.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> shift));
}

std::int64_t number_at(std::span<const std::byte> data, std::size_t at) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < 8; ++i) value = value << 8 | std::to_integer<std::uint64_t>(data[at + i]);
    return static_cast<std::int64_t>(value);
}

/// Appends payload bytes to a NAL unit; 00 00 0x (x < 4) becomes 00 00 03 0x (H.264, 7.4.1).
void put_escaped(std::vector<std::byte>& out, Bytes payload) {
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

std::vector<std::byte> unescaped(Bytes payload) {
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

std::vector<std::byte> sei_nal(const FrameTimes& times) {
    std::vector<std::byte> payload;
    payload.push_back(std::byte{sei_user_data_unregistered});
    payload.push_back(static_cast<std::byte>(message_bytes));
    for (const std::uint8_t byte : frame_times_uuid) payload.push_back(std::byte{byte});
    for (const std::int64_t value : {times.sequence, times.world_ns, times.monotonic_ns, times.realtime_ns})
        put_number(payload, value);
    payload.push_back(std::byte{0x80});  // the stop bit
    std::vector<std::byte> nal = {std::byte{0}, std::byte{0}, std::byte{0}, std::byte{1}, std::byte{nal_sei}};
    put_escaped(nal, payload);
    return nal;
}

/// Walks the messages of an SEI NAL unit's payload (H.264, 7.3.2.3.1).
std::optional<FrameTimes> message_in(std::span<const std::byte> sei) {
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
        if (type != sei_user_data_unregistered || size != message_bytes) continue;
        if (!std::ranges::equal(body.first(frame_times_uuid.size()), frame_times_uuid, {},
                                [](std::byte byte) { return std::to_integer<std::uint8_t>(byte); }))
            continue;
        constexpr std::size_t first = frame_times_uuid.size();
        return FrameTimes{number_at(body, first), number_at(body, first + 8), number_at(body, first + 16),
                          number_at(body, first + 24)};
    }
    return std::nullopt;
}

}  // namespace

std::vector<std::byte> with_frame_times(Bytes access_unit, const FrameTimes& times) {
    std::vector<std::byte> out;
    std::size_t at = 0;
    for (auto nal = next_nal(access_unit, 0); nal; nal = next_nal(access_unit, nal->end)) {
        if (!is_slice(*nal)) continue;
        const auto message = sei_nal(times);
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

std::optional<FrameTimes> find_frame_times(Bytes access_unit) {
    for (auto nal = next_nal(access_unit, 0); nal; nal = next_nal(access_unit, nal->end)) {
        if (is_slice(*nal)) return std::nullopt;
        if (nal->type != nal_sei) continue;
        const auto payload = unescaped(access_unit.subspan(nal->header + 1, nal->end - nal->header - 1));
        if (auto found = message_in(payload)) return found;
    }
    return std::nullopt;
}

}  // namespace camrig
