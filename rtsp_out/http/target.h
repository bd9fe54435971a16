#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace camrig::http {

inline constexpr std::size_t max_target_length = 2048;
inline constexpr std::size_t max_query_parameters = 16;

/// The target of an HTTP request, decoded and safe to compare and to log: printable ASCII only, no "." or ".."
/// segments, no encoded slash, no NUL.
struct Target {
    std::string path;                                        ///< "/", "/cameras/lobby/stream.mjpg"
    std::vector<std::pair<std::string, std::string>> query;  ///< in order, each name once

    /// The value of a parameter, or null.
    const std::string* find(std::string_view name) const;
};

/// Takes origin-form ("/path?query"), absolute-form ("http://host/path?query") and "*" (RFC 9112 section 3.2). Pure.
/// '+' stands for itself. Anything ambiguous is refused rather than guessed.
Result<Target> parse_target(std::string_view text);

/// Whether a Host field is a host with or without a port: "rig:8080", "10.0.0.1", "[::1]:80". Pure.
bool is_host_field(std::string_view text);

/// Splits "/cameras/lobby/stream.mjpg" into its segments without slashes; "/" has none.
std::vector<std::string_view> segments_of(std::string_view path);

}  // namespace camrig::http
