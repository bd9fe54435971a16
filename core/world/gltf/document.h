#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/world/gltf/limits.h"
#include "core/world/gltf/tiny_gltf.h"

namespace camrig::world::gltf {

/// A parsed glTF file whose indices and ranges nobody has checked yet, with its buffers in memory.
struct Document {
    nlohmann::json json;   ///< for what tinygltf drops or has no place for; well typed where `gltf` is used
    tinygltf::Model gltf;  ///< without buffers and images
    std::filesystem::path base;
    std::vector<std::vector<std::byte>> buffers;

    bool uses_extension(std::string_view name) const;
    /// Bytes of a buffer view; checked. Throws Failure.
    std::span<const std::byte> view(std::int64_t index, std::string_view place) const;
};

/// Parses and checks form: version, required extensions, counts, types of all known integers, sizes of buffers.
/// Throws Failure.
Document parse_document(std::span<const std::byte> bytes, const std::filesystem::path& base, Budget& budget);

}  // namespace camrig::world::gltf
