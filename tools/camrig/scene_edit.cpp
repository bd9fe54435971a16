#include "tools/camrig/scene_edit.h"

#include <fstream>
#include <sstream>

#include "core/base/json_reader.h"
#include "core/base/write_file.h"

namespace camrig::cli {

namespace {
constexpr std::size_t max_scene_bytes = std::size_t{16} << 20;
}

Result<OrderedJson> read_scene_text(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    if (!(text << stream.rdbuf())) return error(ErrorKind::not_found, file.string() + ": cannot be read");
    // The strict reader first: it says where the text is wrong.
    if (const auto good = parse_json(text.str(), max_scene_bytes); !good) return at(file.string(), good.error());
    OrderedJson scene = OrderedJson::parse(text.str());
    if (!scene.is_object()) return error(ErrorKind::invalid_argument, file.string() + ": expected an object");
    return scene;
}

Result<void> write_json_text(const std::filesystem::path& file, const OrderedJson& value) {
    const std::string text = value.dump(2) + "\n";
    return write_atomically(file, std::as_bytes(std::span(text)));
}

Result<OrderedJson*> camera_of(OrderedJson& scene, const std::string& name, bool may_add) {
    if (!scene.contains("cameras") && may_add) scene["cameras"] = OrderedJson::array();
    if (!scene.contains("cameras") || !scene["cameras"].is_array())
        return error(ErrorKind::invalid_argument, "cameras: expected a list");
    for (OrderedJson& each : scene["cameras"])
        if (each.is_object() && each.value("name", OrderedJson()) == name) return &each;
    if (!may_add) return error(ErrorKind::not_found, "cameras: has no " + name);
    scene["cameras"].push_back({{"name", name}});
    return &scene["cameras"].back();
}

}  // namespace camrig::cli
