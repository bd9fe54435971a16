#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace camrig::world::gltf {

/// Bytes of a whole regular file, at most `max_bytes`. Throws Failure.
std::vector<std::byte> read_file(const std::filesystem::path& file, std::size_t max_bytes);

/// What a glTF URI names: base64 data, or a file below `base`. Absolute paths, "..", schemes and links that lead out of
/// `base` are refused, and so is every file when `base` is empty. Throws Failure.
std::vector<std::byte> load_uri(std::string_view uri, const std::filesystem::path& base, std::string_view place);

}  // namespace camrig::world::gltf
