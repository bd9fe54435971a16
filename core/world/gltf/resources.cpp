#include "core/world/gltf/resources.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <system_error>

#include "core/base/base64.h"
#include "core/base/percent.h"
#include "core/world/gltf/limits.h"

namespace camrig::world::gltf {
namespace {

constexpr std::size_t max_uri_bytes = 1024;

/// Also without padding, and in the alphabet of URLs (RFC 4648, section 5).
std::vector<std::byte> decode_base64(std::string_view text, std::string_view place) {
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    require(text.size() % 4 != 1, place, "the base64 data is cut short");
    std::string strict(text);
    std::ranges::replace(strict, '-', '+');
    std::ranges::replace(strict, '_', '/');
    strict.resize((strict.size() + 3) / 4 * 4, '=');
    auto bytes = base64_decode(strict);
    require(bytes.has_value(), place, "the data: URI is not base64");
    return std::move(*bytes);
}

std::string decoded(std::string_view uri, std::string_view place) {
    auto out = percent_decode(uri);
    require(out.has_value(), place, "a '%' of the URI is not followed by two hex digits");
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20; };
    require(std::ranges::none_of(*out, is_control), place, "the URI has a control character");
    return std::move(*out);
}

bool is_below(const std::filesystem::path& base, const std::filesystem::path& file) {
    const auto relative = file.lexically_relative(base);
    return !relative.empty() && *relative.begin() != "..";
}

}  // namespace

std::vector<std::byte> read_file(const std::filesystem::path& file, std::size_t max_bytes) {
    std::error_code code;
    const auto status = std::filesystem::status(file, code);
    if (!std::filesystem::exists(status)) fail("", "no such file", ErrorKind::not_found);
    if (!std::filesystem::is_regular_file(status)) fail("", "is not a regular file");
    std::ifstream stream(file, std::ios::binary);
    if (!stream) fail("", "cannot be opened; check its permissions", ErrorKind::unavailable);
    // The size comes from what is read, not from the directory: the file may grow meanwhile.
    std::vector<std::byte> bytes;
    std::array<char, 1 << 16> block;
    while (stream) {
        stream.read(block.data(), block.size());
        const auto got = static_cast<std::size_t>(stream.gcount());
        if (bytes.size() + got > max_bytes) {
            fail("", "is larger than " + std::to_string(max_bytes >> 20) + " MB", ErrorKind::resource_exhausted);
        }
        const auto* data = reinterpret_cast<const std::byte*>(block.data());
        bytes.insert(bytes.end(), data, data + got);
    }
    if (stream.bad()) fail("", "cannot be read", ErrorKind::unavailable);
    return bytes;
}

std::vector<std::byte> load_uri(std::string_view uri, const std::filesystem::path& base, std::string_view place) {
    if (uri.starts_with("data:")) {
        const auto comma = uri.find(',');
        require(comma != std::string_view::npos && uri.substr(0, comma).ends_with(";base64"), place,
                "only base64 data: URIs are read");
        return decode_base64(uri.substr(comma + 1), place);
    }
    require(!uri.empty() && uri.size() <= max_uri_bytes, place, "the URI is empty or too long");
    const std::string name = decoded(uri, place);
    const std::filesystem::path relative(name);
    const std::string shown = "'" + name.substr(0, 100) + "' ";
    require(!base.empty(), place, shown + "names a file, but this model came without a folder");
    bool inside = relative.is_relative() && name.find(':') == std::string::npos && name.find('\\') == std::string::npos;
    for (const auto& part : relative) inside = inside && part != "..";
    require(inside, place, shown + "is not a plain path below the model's folder");

    std::error_code code;
    const auto root = std::filesystem::weakly_canonical(base, code);
    const auto file = std::filesystem::weakly_canonical(base / relative, code);
    require(!code && is_below(root, file), place, shown + "leads out of the model's folder");
    try {
        return read_file(file, max_file_bytes);
    } catch (const Failure& problem) {
        fail(place, shown + problem.error.message, problem.error.kind);
    }
}

}  // namespace camrig::world::gltf
