#include "core/base/base64.h"

#include <array>
#include <cstdint>

namespace camrig {
namespace {

constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

constexpr auto value_of = [] {
    std::array<std::int8_t, 256> values{};
    values.fill(-1);
    for (std::size_t i = 0; i < alphabet.size(); ++i)
        values[static_cast<unsigned char>(alphabet[i])] = static_cast<std::int8_t>(i);
    return values;
}();

}  // namespace

std::string base64_encode(std::span<const std::byte> bytes) {
    std::string text((bytes.size() + 2) / 3 * 4, '=');
    char* out = text.data();
    const auto at = [&](std::size_t i) { return i < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i]) : 0U; };
    const auto put = [&](std::uint32_t group, int digits) {
        for (int i = 0; i < digits; ++i) out[i] = alphabet[(group >> (18 - 6 * i)) & 63U];
        out += 4;
    };
    std::size_t i = 0;
    for (; i + 3 <= bytes.size(); i += 3) put(at(i) << 16 | at(i + 1) << 8 | at(i + 2), 4);
    if (i < bytes.size()) put(at(i) << 16 | at(i + 1) << 8, static_cast<int>(bytes.size() - i) + 1);
    return text;
}

Result<std::vector<std::byte>> base64_decode(std::string_view text) {
    const auto refuse = [] { return error(ErrorKind::invalid_argument, "not base64 (RFC 4648 with padding)"); };
    if (text.size() % 4 != 0) return refuse();
    std::size_t padding = 0;
    while (padding < 2 && padding < text.size() && text[text.size() - 1 - padding] == '=') ++padding;
    std::vector<std::byte> bytes;
    bytes.reserve(text.size() / 4 * 3);
    for (std::size_t i = 0; i < text.size(); i += 4) {
        const std::size_t spare = i + 4 == text.size() ? padding : 0;
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            const int value = k < 4 - spare ? value_of[static_cast<unsigned char>(text[i + k])] : 0;
            if (value < 0) return refuse();
            group = group << 6 | static_cast<std::uint32_t>(value);
        }
        for (std::size_t k = 0; k < 3 - spare; ++k)
            bytes.push_back(static_cast<std::byte>(group >> (16 - 8 * k) & 255U));
    }
    return bytes;
}

}  // namespace camrig
