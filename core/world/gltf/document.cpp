#include "core/world/gltf/document.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/json_reader.h"
#include "core/world/gltf/container.h"
#include "core/world/gltf/resources.h"

// tinygltf 2.7 on bad input: reads image bytes through unchecked buffer views, reads eight bytes past a short BIN
// chunk, cuts integers to 32 bits, and drops primitives and optional members of a wrong type without a word. So it is
// given JSON only, after the types of everything it will look at were checked, and what it made is counted afterwards.
namespace camrig::world::gltf {
namespace {

using nlohmann::json;

constexpr std::array supported_extensions = {
    "KHR_materials_unlit",   "KHR_texture_transform",           "KHR_lights_punctual",
    "KHR_mesh_quantization", "KHR_materials_emissive_strength", "KHR_materials_transmission"};

constexpr std::array array_members = {
    "accessors", "animations", "bufferViews", "buffers", "cameras", "images",         "materials",
    "meshes",    "nodes",      "samplers",    "scenes",  "skins",   "extensionsUsed", "extensionsRequired",
    "textures"};

// Members that are integers wherever they appear (outside extras); "indices" and "target" are objects elsewhere.
constexpr std::array integer_members = {"buffer",     "bufferView",
                                        "byteOffset", "byteLength",
                                        "byteStride", "componentType",
                                        "count",      "mesh",
                                        "skin",       "camera",
                                        "material",   "mode",
                                        "sampler",    "source",
                                        "index",      "texCoord",
                                        "node",       "input",
                                        "output",     "scene",
                                        "skeleton",   "inverseBindMatrices",
                                        "minFilter",  "magFilter",
                                        "wrapS",      "wrapT",
                                        "light"};
constexpr std::array integer_or_object_members = {"indices", "target"};
constexpr std::array number_list_members = {"translation",     "rotation",       "matrix", "weights", "color",
                                            "baseColorFactor", "emissiveFactor", "min",    "max"};
constexpr std::array integer_list_members = {"children", "joints"};

bool among(const auto& names, std::string_view name) {
    return std::ranges::find(names, name) != names.end();
}

constexpr double max_integer = 2147483647.0;

/// Makes an integer written as 100.0 an integer; refuses everything else that tinygltf would take for "absent".
void check_integer(json& value, const std::string& place) {
    if (value.is_number_float() && std::trunc(value.get<double>()) == value.get<double>() && value.get<double>() >= 0 &&
        value.get<double>() <= max_integer)
        value = static_cast<std::uint64_t>(value.get<double>());
    const bool good = value.is_number_unsigned() && value.get<std::uint64_t>() <= std::uint64_t{2147483647};
    require(good, place, "expected an integer from 0 to 2147483647, got " + value.dump().substr(0, 40));
}

void check_numbers(const json& value, const std::string& place) {
    require(value.is_array(), place, "expected an array of numbers");
    for (const json& number : value) require(number.is_number(), place, "expected an array of numbers");
}

/// Depth is bounded by parse_json.
void check_types(json& value, const std::string& place) {
    if (value.is_array()) {
        for (std::size_t i = 0; i < value.size(); ++i)
            if (value[i].is_structured()) check_types(value[i], item(place, i));
        return;
    }
    for (auto& [key, member] : value.items()) {
        const auto at = [&] { return place.empty() ? key : place + "." + key; };
        if (key == "extras") continue;
        if (key == "extensions") {
            // Extensions nobody reads may use the same names in other ways.
            require(member.is_object(), at(), "expected an object");
            for (auto& [name, extension] : member.items())
                if (among(supported_extensions, name) && extension.is_structured())
                    check_types(extension, at() + "." + name);
        } else if (key == "name") {
            require(member.is_string(), at(), "expected a string");
        } else if (key == "attributes") {
            require(member.is_object(), at(), "expected an object");
            for (auto& [name, accessor] : member.items()) check_integer(accessor, at() + "." + name);
        } else if (key == "targets") {
            require(member.is_array(), at(), "expected an array");
            for (auto& target : member) {
                require(target.is_object(), at(), "expected an array of objects");
                for (auto& [name, accessor] : target.items()) check_integer(accessor, at() + "." + name);
            }
        } else if (among(integer_members, key) || (among(integer_or_object_members, key) && !member.is_object())) {
            // KHR_texture_transform and KHR_lights_punctual use none of these names for anything else.
            check_integer(member, at());
        } else if (among(integer_list_members, key)) {
            require(member.is_array(), at(), "expected an array of integers");
            for (std::size_t i = 0; i < member.size(); ++i) check_integer(member[i], item(at(), i));
        } else if (among(number_list_members, key) && !member.is_number()) {
            check_numbers(member, at());
        } else if (member.is_structured()) {
            check_types(member, at());
        }
    }
}

void check_form(json& root) {
    require(root.is_object(), "", "the file is not a glTF document");
    const auto asset = root.find("asset");
    require(asset != root.end() && asset->is_object() && asset->contains("version") && (*asset)["version"].is_string(),
            "asset.version", "is missing");
    const auto version = (*asset)["version"].get<std::string>();
    if (!version.starts_with("2."))
        fail("asset.version", "glTF " + version.substr(0, 20) + "; glTF 2.0 is read", ErrorKind::unsupported);
    for (const char* name : array_members) {
        const auto member = root.find(name);
        if (member == root.end()) continue;
        require(member->is_array(), name, "expected an array");
        require(member->size() <= max_items, name, "more than " + std::to_string(max_items) + " items");
        const bool strings = std::string_view(name).starts_with("extensions");
        for (std::size_t i = 0; i < member->size(); ++i) {
            require(strings ? (*member)[i].is_string() : (*member)[i].is_object(), item(name, i),
                    strings ? "expected a string" : "expected an object");
        }
    }
    if (const auto required = root.find("extensionsRequired"); required != root.end()) {
        for (const json& name : *required) {
            if (among(supported_extensions, name.get<std::string>())) continue;
            fail("extensionsRequired",
                 "the file needs the extension " + name.get<std::string>().substr(0, 80) +
                     ", which is not supported; supported: KHR_materials_unlit, "
                     "KHR_texture_transform, KHR_lights_punctual, KHR_mesh_quantization, "
                     "KHR_materials_emissive_strength, KHR_materials_transmission",
                 ErrorKind::unsupported);
        }
    }
    check_types(root, "");
}

std::vector<std::byte> load_buffer(const json& buffer, std::size_t index, const Container& container,
                                   const std::filesystem::path& base) {
    const std::string place = item("buffers", index);
    require(buffer.contains("byteLength"), place + ".byteLength", "is missing");
    const auto length = buffer["byteLength"].get<std::uint64_t>();
    std::vector<std::byte> data;
    if (buffer.contains("uri")) {
        require(buffer["uri"].is_string(), place + ".uri", "expected a string");
        data = load_uri(buffer["uri"].get_ref<const std::string&>(), base, place + ".uri");
    } else {
        require(index == 0 && container.has_binary, place, "has no uri and there is no BIN chunk for it");
        data.assign(container.binary.begin(), container.binary.end());
    }
    require(length <= data.size(), place + ".byteLength",
            std::to_string(length) + " bytes are promised, " + std::to_string(data.size()) + " are there");
    data.resize(length);
    return data;
}

void parse_with_tinygltf(const json& root, tinygltf::Model& model) {
    json reduced = root;
    for (const char* name : {"buffers", "images"}) reduced.erase(name);
    const std::string text = reduced.dump();
    tinygltf::TinyGLTF parser;
    std::string errors, warnings;
    bool parsed = false;
    try {
        parsed = parser.LoadASCIIFromString(&model, &errors, &warnings, text.data(),
                                            static_cast<unsigned int>(text.size()), "");
    } catch (const std::exception& problem) {
        errors = problem.what();
    }
    std::ranges::replace(errors, '\n', ' ');
    if (!parsed) fail("", errors.empty() ? "tinygltf cannot read the file" : errors.substr(0, 300));

    const auto count = [&](const json& owner, const char* name) {
        return owner.contains(name) ? owner[name].size() : std::size_t{0};
    };
    for (std::size_t i = 0; i < model.meshes.size(); ++i) {
        require(model.meshes[i].primitives.size() == count(root["meshes"][i], "primitives"), item("meshes", i),
                "a primitive is malformed: " + errors.substr(0, 200));
    }
    for (std::size_t i = 0; i < model.animations.size(); ++i) {
        require(model.animations[i].samplers.size() == count(root["animations"][i], "samplers"), item("animations", i),
                "a sampler is malformed: " + errors.substr(0, 200));
    }
}

}  // namespace

bool Document::uses_extension(std::string_view name) const {
    return std::ranges::find(gltf.extensionsUsed, name) != gltf.extensionsUsed.end() ||
           std::ranges::find(gltf.extensionsRequired, name) != gltf.extensionsRequired.end();
}

std::span<const std::byte> Document::view(std::int64_t index, std::string_view place) const {
    require(index >= 0 && index < std::ssize(gltf.bufferViews), place,
            "buffer view " + std::to_string(index) + " of " + std::to_string(gltf.bufferViews.size()));
    const auto& view = gltf.bufferViews[static_cast<std::size_t>(index)];
    require(view.buffer >= 0 && view.buffer < std::ssize(buffers), place,
            "buffer " + std::to_string(view.buffer) + " of " + std::to_string(buffers.size()));
    const auto& buffer = buffers[static_cast<std::size_t>(view.buffer)];
    require(view.byteOffset <= buffer.size() && view.byteLength <= buffer.size() - view.byteOffset, place,
            "its buffer view leaves the buffer");
    return std::span(buffer).subspan(view.byteOffset, view.byteLength);
}

Document parse_document(std::span<const std::byte> bytes, const std::filesystem::path& base, Budget& budget) {
    const Container container = split_container(bytes);
    Document document;
    document.base = base;
    auto parsed = parse_json(container.json, max_json_bytes);
    if (!parsed) fail(container.is_binary ? "JSON chunk" : "", parsed.error().message, parsed.error().kind);
    document.json = std::move(*parsed);
    check_form(document.json);
    if (const auto buffers = document.json.find("buffers"); buffers != document.json.end()) {
        for (std::size_t i = 0; i < buffers->size(); ++i) {
            document.buffers.push_back(load_buffer((*buffers)[i], i, container, base));
            budget.take(document.buffers.back().size(), item("buffers", i));
        }
    }
    parse_with_tinygltf(document.json, document.gltf);
    return document;
}

}  // namespace camrig::world::gltf
