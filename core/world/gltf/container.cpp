#include "core/world/gltf/container.h"

#include <cstdint>
#include <cstring>
#include <string>

#include "core/world/gltf/failure.h"

namespace camrig::world::gltf {
namespace {

constexpr std::uint32_t magic_glb = 0x46546C67;   // "glTF"
constexpr std::uint32_t chunk_json = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t chunk_bin = 0x004E4942;   // "BIN\0"
constexpr std::size_t header_bytes = 12;
constexpr std::size_t chunk_header_bytes = 8;

std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t offset) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

bool looks_like_json(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // a byte order mark
    const auto first = text.find_first_not_of(" \t\r\n");
    return first != std::string_view::npos && text[first] == '{';
}

/// The first bytes for a message: 'PK??', where what is not printable is a question mark.
std::string beginning(std::string_view text) {
    std::string shown(text.substr(0, 8));
    for (char& c : shown)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';
    return shown.empty() ? "nothing" : "'" + shown + "'";
}

}  // namespace

Container split_container(std::span<const std::byte> bytes) {
    const auto text = [](std::span<const std::byte> part) {
        return std::string_view(reinterpret_cast<const char*>(part.data()), part.size());
    };
    if (bytes.size() < 4 || read_u32(bytes, 0) != magic_glb) {
        require(looks_like_json(text(bytes)), "",
                "is neither .glb nor .gltf: " + std::to_string(bytes.size()) + " bytes that begin with " +
                    beginning(text(bytes)) + "; a .glb begins with 'glTF', a .gltf with '{'");
        return {.json = text(bytes)};
    }

    require(bytes.size() >= header_bytes, "header", "the file ends in the GLB header");
    const std::uint32_t version = read_u32(bytes, 4);
    require(version == 2, "header.version", "GLB version " + std::to_string(version) + "; version 2 is read");
    const std::size_t length = read_u32(bytes, 8);
    require(length <= bytes.size(), "header.length",
            "the header promises " + std::to_string(length) + " bytes, the file has " + std::to_string(bytes.size()));
    bytes = bytes.first(length);

    Container result;
    result.is_binary = true;
    bool json_seen = false;
    for (std::size_t offset = header_bytes; offset < bytes.size();) {
        require(bytes.size() - offset >= chunk_header_bytes, "chunk", "the file ends in a chunk header");
        const std::size_t size = read_u32(bytes, offset);
        const std::uint32_t type = read_u32(bytes, offset + 4);
        offset += chunk_header_bytes;
        require(size <= bytes.size() - offset, "chunk", "a chunk is longer than the file");
        const auto payload = bytes.subspan(offset, size);
        require(json_seen || type == chunk_json, "chunk", "the first chunk is not JSON");
        if (type == chunk_json && !json_seen) {
            result.json = text(payload);
            json_seen = true;
        } else if (type == chunk_bin && !result.has_binary) {
            result.binary = payload;
            result.has_binary = true;
        }  // unknown chunks are skipped (glTF 2.0, 4.4.3)
        offset += size;
    }
    require(json_seen, "chunk", "there is no JSON chunk");
    // The standard pads with spaces; files padded with NUL exist.
    while (!result.json.empty() && result.json.back() == '\0') result.json.remove_suffix(1);
    return result;
}

}  // namespace camrig::world::gltf
