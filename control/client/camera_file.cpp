#include "control/client/camera_file.h"

#include <fstream>
#include <system_error>

#include "core/base/json_reader.h"

namespace camrig::client {
namespace {

using nlohmann::json;

constexpr std::size_t max_file_bytes = 4 << 20;
constexpr std::size_t max_cameras_in_file = 1024;

}  // namespace

Result<json> read_camera_file(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::error_code ignored;
    if (!stream || std::filesystem::is_directory(file, ignored))
        return error(ErrorKind::not_found, file.string() + ": cannot be read");
    std::string text;
    for (char c; text.size() <= max_file_bytes && stream.get(c);) text += c;
    auto value = parse_json(text, max_file_bytes);
    if (!value) return at(file.string(), value.error());
    if (value->is_object() && value->contains("cameras")) {
        JsonReader reader(*value, "");
        const auto items = reader.array("cameras", max_cameras_in_file);
        json list(json::array());
        for (const json& item : items) list.push_back(item);
        if (auto done = reader.finish(); !done) return at(file.string(), done.error());
        return list;
    }
    if (value->is_object()) return json::array({*value});
    if (value->is_array() && value->size() <= max_cameras_in_file) return value;
    return error(ErrorKind::invalid_argument,
                 file.string() + ": must be a camera, a list of at most 1024 of them, or {\"cameras\": [...]}");
}

std::string camera_in_file(const std::filesystem::path& file, std::size_t index) {
    return file.string() + ": cameras[" + std::to_string(index) + "]" +
           (index > 0 ? " (those before it were made): " : ": ");
}

}  // namespace camrig::client
