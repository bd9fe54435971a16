#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace camrig {

/// RFC 4648, with padding, no line breaks.
std::string base64_encode(std::span<const std::byte> bytes);
/// How long the text of so many bytes is.
constexpr std::size_t base64_size(std::size_t bytes) {
    return (bytes + 2) / 3 * 4;
}
/// Strict: the alphabet and the padding must be right. Bits behind the last byte are of no account (RFC 4648, 3.5).
Result<std::vector<std::byte>> base64_decode(std::string_view text);

}  // namespace camrig
