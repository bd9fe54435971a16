#pragma once

#include <string_view>

#include "core/base/result.h"

namespace camrig {

inline constexpr std::size_t max_name_length = 24;

/// Names of cameras: `[a-z0-9_]{1,24}`. They become URLs, card labels, ROS names and file names, so nothing else is let
/// in.
inline Result<void> check_name(std::string_view what, std::string_view name) {
    bool good = !name.empty() && name.size() <= max_name_length;
    for (const char c : name) good = good && ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_');
    if (good) return {};
    std::string shown(name.substr(0, 40));
    for (char& c : shown)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';
    return error(ErrorKind::invalid_argument,
                 std::string(what) + ": '" + shown + "' is not a name; use 1 to 24 of a-z, 0-9 and _");
}

}  // namespace camrig
