#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace camrig::world {

/// Puts GLB files together in memory: a JSON document that starts with an asset, and one buffer that grows.
class GlbBuilder {
public:
    nlohmann::json json = {{"asset", {{"version", "2.0"}}}};
    std::vector<std::byte> binary;

    /// A buffer view over these bytes; returns its index.
    int view(const void* data, std::size_t size) {
        while (binary.size() % 4) binary.push_back(std::byte{0});
        const auto* bytes = static_cast<const std::byte*>(data);
        json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", size}});
        binary.insert(binary.end(), bytes, bytes + size);
        return static_cast<int>(json["bufferViews"].size()) - 1;
    }
    /// An accessor over these numbers; returns its index.
    template <typename T>
    int accessor(const std::vector<T>& values, const std::string& type, int component_type, bool normalized = false) {
        const std::size_t width = type == "SCALAR" ? 1
                                  : type == "VEC2" ? 2
                                  : type == "VEC3" ? 3
                                  : type == "VEC4" ? 4
                                                   : 16;
        const int at = view(values.data(), values.size() * sizeof(T));
        json["accessors"].push_back({{"bufferView", at},
                                     {"componentType", component_type},
                                     {"normalized", normalized},
                                     {"count", values.size() / width},
                                     {"type", type}});
        return static_cast<int>(json["accessors"].size()) - 1;
    }
    int floats(const std::vector<float>& values, const std::string& type) { return accessor(values, type, 5126); }
    int shorts(const std::vector<std::uint16_t>& values, const std::string& type) {
        return accessor(values, type, 5123);
    }
    int bytes(const std::vector<std::uint8_t>& values, const std::string& type) { return accessor(values, type, 5121); }

    /// One node, one mesh, one primitive with these positions and whatever `primitive` adds.
    GlbBuilder& mesh(const std::vector<float>& positions, nlohmann::json primitive = nlohmann::json::object()) {
        primitive["attributes"]["POSITION"] = floats(positions, "VEC3");
        json["meshes"] = {{{"primitives", {primitive}}}};
        json["nodes"] = {{{"name", "node"}, {"mesh", 0}}};
        json["scenes"] = {{{"nodes", {0}}}};
        return *this;
    }

    std::vector<std::byte> build() const {
        nlohmann::json document = json;
        if (!binary.empty()) document["buffers"] = {{{"byteLength", binary.size()}}};
        return assemble(document.dump(), binary);
    }
    static std::vector<std::byte> assemble(std::string text, std::vector<std::byte> bin) {
        while (text.size() % 4) text += ' ';
        while (bin.size() % 4) bin.push_back(std::byte{0});
        std::vector<std::byte> out;
        const auto u32 = [&](std::size_t value) {
            const auto narrow = static_cast<std::uint32_t>(value);
            const auto* raw = reinterpret_cast<const std::byte*>(&narrow);
            out.insert(out.end(), raw, raw + 4);
        };
        u32(0x46546C67);
        u32(2);
        u32(12 + 8 + text.size() + (bin.empty() ? 0 : 8 + bin.size()));
        u32(text.size());
        u32(0x4E4F534A);
        const auto* raw = reinterpret_cast<const std::byte*>(text.data());
        out.insert(out.end(), raw, raw + text.size());
        if (bin.empty()) return out;
        u32(bin.size());
        u32(0x004E4942);
        out.insert(out.end(), bin.begin(), bin.end());
        return out;
    }
};

}  // namespace camrig::world
