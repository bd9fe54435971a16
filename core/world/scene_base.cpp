#include "core/world/scene_base.h"

#include <algorithm>
#include <map>
#include <string>

#include "core/base/json_reader.h"
#include "core/world/gltf/failure.h"
#include "core/world/gltf/resources.h"
#include "core/world/scene_reader.h"
#include "core/world/shipped.h"

namespace camrig::world {
namespace {

using nlohmann::json;

constexpr std::size_t max_bases = 8;

bool is_named_list(const json& value) {
    return value.is_array() && std::ranges::all_of(value, [](const json& item) {
               return item.is_object() && item.contains("name") && item["name"].is_string();
           });
}

void put_over(json& base, const json& change);

void put_over_list(json& base, const json& change) {
    std::map<std::string, std::size_t, std::less<>> places;
    for (std::size_t n = 0; n < base.size(); ++n) places.emplace(base[n]["name"].get_ref<const std::string&>(), n);
    for (const json& item : change) {
        const auto& name = item["name"].get_ref<const std::string&>();
        const auto [place, is_new] = places.emplace(name, base.size());
        if (is_new) base.emplace_back(json::object());
        put_over(base[place->second], item);
    }
}

/// JSON Merge Patch (RFC 7396), but that lists of what has names are merged by these.
void put_over(json& base, const json& change) {
    for (const auto& [key, value] : change.items()) {
        if (value.is_null()) {
            base.erase(key);
        } else if (json& kept = base[key]; value.is_object()) {
            if (!kept.is_object()) kept = json::object();
            put_over(kept, value);
        } else if (!kept.empty() && is_named_list(kept) && is_named_list(value)) {
            put_over_list(kept, value);
        } else {
            kept = value;
        }
    }
}

/// Models of a shipped scene, for a file that lies elsewhere.
void name_as_shipped(json& document) {
    const auto models = document.find("models");
    if (models == document.end() || !models->is_object()) return;
    for (auto& [name, model] : models->items()) {
        const auto file = model.is_object() ? model.find("file") : model.end();
        if (!model.is_object() || file == model.end() || !file->is_string()) continue;
        const auto text = file->get<std::string>();
        if (!text.starts_with(shipped_prefix)) *file = std::string(shipped_prefix) + text;
    }
}

bool is_shipped(const std::string& name) {
    return name.starts_with(shipped_prefix);
}

Result<std::filesystem::path> base_file(const std::string& text, const std::filesystem::path& file) {
    if (is_shipped(text)) {
        auto found = find_shipped_scene(text.substr(shipped_prefix.size()));
        if (!found) return at("base", found.error());
        return found;
    }
    if (!leads_below(text) || text.find('/') != std::string::npos || !text.ends_with(".json"))
        return error(ErrorKind::invalid_argument,
                     "base: must be a .json file of the same folder, or camrig: and the name of a shipped scene");
    return file.parent_path() / text;
}

}  // namespace

Result<json> read_scene_document(const std::filesystem::path& file) {
    std::vector<std::byte> bytes;
    try {
        bytes = gltf::read_file(file, max_scene_bytes);
    } catch (const gltf::Failure& failure) {
        return std::unexpected(failure.error);
    }
    return parse_json({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, max_scene_bytes);
}

Result<BasedScene> on_its_base(json document, const std::filesystem::path& file) {
    BasedScene made;
    std::vector<json> changes;
    bool are_shipped = false;  // and what they stand on
    for (std::filesystem::path at = file; document.contains("base");) {
        if (made.bases.size() == max_bases)
            return error(ErrorKind::invalid_argument,
                         "base: more than " + std::to_string(max_bases) + " files stand on each other");
        if (!document["base"].is_string()) return error(ErrorKind::invalid_argument, "base: expected a string");
        const auto name = document["base"].get<std::string>();
        const auto below = base_file(name, at);
        if (!below) return std::unexpected(below.error());
        const std::string place = "base: " + below->string();
        auto read = read_scene_document(*below);
        if (!read) return camrig::at(place, read.error());
        if (!read->is_object())
            return error(ErrorKind::invalid_argument, place + ": expected an object, got " + read->type_name());
        are_shipped |= is_shipped(name);
        if (are_shipped) name_as_shipped(*read);
        document.erase("base");
        changes.push_back(std::move(document));
        document = std::move(*read);
        at = *below;
        made.bases.push_back(*below);
    }
    for (auto change = changes.rbegin(); change != changes.rend(); ++change) put_over(document, *change);
    made.document = std::move(document);
    return made;
}

}  // namespace camrig::world
