#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace camrig {

/// Tokens travel in URLs, headers and cookies, so they are 8 to 256 of the characters that survive in all three:
/// letters, digits and - . _ ~ + / = .
Result<void> check_token(std::string_view token);

/// The token of --token-file: the file's one line.
Result<std::string> read_token_file(const std::filesystem::path& file);

/// The time does not depend on where two tokens differ.
bool equal_tokens(std::string_view given, std::string_view expected);

}  // namespace camrig
