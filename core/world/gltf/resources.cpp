#include "core/world/gltf/resources.h"

#include <array>
#include <fstream>
#include <string>

#include "core/world/gltf/limits.h"

namespace camrig::gltf {
namespace {

constexpr std::size_t max_uri_bytes = 1024;

int base64_digit(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62;
    if (c == '/' || c == '_') return 63;
    return -1;
}

std::vector<std::byte> decode_base64(std::string_view text, std::string_view place) {
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    require(text.size() % 4 != 1, place, "the base64 data is cut short");
    std::vector<std::byte> out;
    out.reserve(text.size() / 4 * 3 + 2);
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        const int digit = base64_digit(c);
        require(digit >= 0, place, "the data: URI is not base64");
        bits = (bits << 6) | static_cast<std::uint32_t>(digit);
        count += 6;
        if (count >= 8) {
            count -= 8;
            out.push_back(static_cast<std::byte>((bits >> count) & 0xFF));
        }
    }
    return out;
}

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

std::string percent_decode(std::string_view uri, std::string_view place) {
    std::string out;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        char c = uri[i];
        if (c == '%') {
            const int high = i + 2 < uri.size() ? hex_digit(uri[i + 1]) : -1;
            const int low = i + 2 < uri.size() ? hex_digit(uri[i + 2]) : -1;
            require(high >= 0 && low >= 0, place, "a '%' of the URI is not followed by two hex digits");
            c = static_cast<char>(high * 16 + low);
            i += 2;
        }
        require(static_cast<unsigned char>(c) >= 0x20, place, "the URI has a control character");
        out += c;
    }
    return out;
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
    const std::string name = percent_decode(uri, place);
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

}  // namespace camrig::gltf
