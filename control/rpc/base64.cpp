#include <cstdint>
#include <span>
#include <string>

#include "control/rpc/methods.h"

namespace camrig {

std::string base64(std::span<const std::byte> bytes) {
    static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.resize((bytes.size() + 2) / 3 * 4);
    std::size_t out = 0;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const auto byte = [&](std::size_t k) {
            return i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0u;
        };
        const std::uint32_t group = byte(0) << 16 | byte(1) << 8 | byte(2);
        text[out++] = digits[group >> 18];
        text[out++] = digits[group >> 12 & 63];
        text[out++] = i + 1 < bytes.size() ? digits[group >> 6 & 63] : '=';
        text[out++] = i + 2 < bytes.size() ? digits[group & 63] : '=';
    }
    return text;
}

}  // namespace camrig
