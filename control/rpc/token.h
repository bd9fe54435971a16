#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace camrig {

/// The token of --token-file: the file's one line, 8 to 256 of letters, digits and - . _ ~ + / = (it also travels in
/// URLs).
Result<std::string> read_token_file(const std::filesystem::path& file);

/// The time does not depend on where two tokens differ.
bool equal_tokens(std::string_view given, std::string_view expected);

}  // namespace camrig
