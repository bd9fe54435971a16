#include "core/world/baked/baked_light_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>

#include <libdeflate.h>
#include <spdlog/spdlog.h>

#include "core/base/json_reader.h"
#include "core/world/baked/baked_light_header.h"
#include "core/world/baked/light_bytes.h"
#include "core/world/gltf/failure.h"
#include "core/world/gltf/resources.h"

namespace camrig::world {
namespace {

// A line, the length of a JSON text, the text, and then parts that are compressed each by itself: cuts of the models
// that are cut, which probes are open, how near reflection probes see things, and of each layer its texels, its probes
// and its reflections.
constexpr std::string_view magic = "camrig light 6\n";
constexpr std::size_t max_header_bytes = std::size_t{16} << 20;
constexpr std::size_t max_part_bytes = std::size_t{512} << 20;

class Writer {
public:
    void add(std::span<const std::byte> bytes) { out_.insert(out_.end(), bytes.begin(), bytes.end()); }
    void add_size(std::uint64_t size) {
        for (int i = 0; i < 8; ++i) out_.push_back(static_cast<std::byte>(size >> (8 * i)));
    }
    void add_part(std::span<const std::byte> bytes) {
        const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> compressor(
            libdeflate_alloc_compressor(12), libdeflate_free_compressor);
        std::vector<std::byte> packed(libdeflate_deflate_compress_bound(compressor.get(), bytes.size()));
        packed.resize(
            libdeflate_deflate_compress(compressor.get(), bytes.data(), bytes.size(), packed.data(), packed.size()));
        add_size(bytes.size());
        add_size(packed.size());
        add(packed);
    }
    std::vector<std::byte> take() { return std::move(out_); }

private:
    std::vector<std::byte> out_;
};

class Reader {
public:
    explicit Reader(std::span<const std::byte> bytes) : left_(bytes) {}

    Result<std::span<const std::byte>> take(std::uint64_t size) {
        if (size > left_.size()) return error(ErrorKind::invalid_argument, "ends too early");
        const auto taken = left_.first(size);
        left_ = left_.subspan(size);
        return taken;
    }
    Result<std::uint64_t> take_size() {
        const auto bytes = take(8);
        if (!bytes) return std::unexpected(bytes.error());
        std::uint64_t size = 0;
        for (std::size_t i = 0; i < 8; ++i) size |= std::to_integer<std::uint64_t>((*bytes)[i]) << (8 * i);
        return size;
    }
    /// Of exactly that size when it is unpacked, which follows from the text.
    Result<std::vector<std::byte>> take_part(std::size_t size) {
        const auto raw = take_size();
        if (!raw) return std::unexpected(raw.error());
        const auto packed_size = take_size();
        if (!packed_size) return std::unexpected(packed_size.error());
        if (*raw != size || size > max_part_bytes)
            return error(ErrorKind::invalid_argument, "a part has another length than its text says");
        const auto packed = take(*packed_size);
        if (!packed) return std::unexpected(packed.error());
        const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> unpacker(
            libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
        std::vector<std::byte> bytes(size);
        if (libdeflate_deflate_decompress(unpacker.get(), packed->data(), packed->size(), bytes.data(), size,
                                          nullptr) != LIBDEFLATE_SUCCESS)
            return error(ErrorKind::invalid_argument, "a part cannot be unpacked");
        return bytes;
    }
    bool is_at_end() const { return left_.empty(); }

private:
    std::span<const std::byte> left_;
};

template <typename T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

template <typename T>
void append(const std::vector<T>& values, std::vector<std::byte>& to) {
    const auto bytes = bytes_of(values);
    to.insert(to.end(), bytes.begin(), bytes.end());
}

template <typename T>
void take_values(std::span<const std::byte>& from, std::size_t count, std::vector<T>& to) {
    to.resize(count);
    std::ranges::copy(from.first(count * sizeof(T)), std::as_writable_bytes(std::span(to)).begin());
    from = from.subspan(count * sizeof(T));
}

constexpr std::size_t bytes_of_vertex = sizeof(std::uint32_t) + sizeof(glm::vec2);

/// Whether it has the triangles of the file, in its rectangle.
bool is_cut_of(const Primitive& source, const BakedPrimitive& cut) {
    const glm::vec2 size(cut.size.width, cut.size.height);
    const auto is_inside = [&](const glm::vec2& at) {
        return at.x >= 0.0f && at.y >= 0.0f && at.x <= size.x && at.y <= size.y;
    };
    const auto is_there = [&](std::uint32_t vertex) { return vertex < source.positions.size(); };
    if (!std::ranges::all_of(cut.coordinates, is_inside) || !std::ranges::all_of(cut.vertices, is_there)) return false;
    return std::ranges::equal(cut.indices, source.indices, [&](std::uint32_t own, std::uint32_t of_file) {
        return own < cut.vertices.size() && cut.vertices[own] == of_file;
    });
}

Result<void> read_cuts(Reader& reader, const std::vector<BakedLightHeader::Counts>& counts, const Scene& scene,
                       BakedLight& light) {
    std::size_t number = 0;
    for (BakedModel& model : light.models) {
        std::size_t size = 0;
        for (std::size_t i = 0; i < model.primitives.size(); ++i)
            size += counts[number + i].vertices * bytes_of_vertex + counts[number + i].indices * sizeof(std::uint32_t);
        const auto part = reader.take_part(size);
        if (!part) return std::unexpected(part.error());
        std::span<const std::byte> left(*part);
        const std::vector<const Primitive*> sources = primitives_of(*scene.models.at(model.name).model);
        for (std::size_t i = 0; i < model.primitives.size(); ++i, ++number) {
            BakedPrimitive& primitive = model.primitives[i];
            take_values(left, counts[number].vertices, primitive.vertices);
            take_values(left, counts[number].vertices, primitive.coordinates);
            take_values(left, counts[number].indices, primitive.indices);
            if (primitive.size.width > 0 && !is_cut_of(*sources[i], primitive))
                return error(ErrorKind::invalid_argument,
                             "models." + model.name + ": primitive " + std::to_string(i) + " is none of this model");
        }
    }
    return {};
}

Result<void> read_layers(Reader& reader, BakedLight& light) {
    const auto open = reader.take_part(light.grid.size());
    if (!open) return std::unexpected(open.error());
    std::span<const std::byte> left(*open);
    take_values(left, light.grid.size(), light.grid.is_open);
    const std::size_t reflections = light.reflection_probes.places.size();
    const auto nearness = reader.take_part(reflections * texels_of_nearness * bytes_of_nearness);
    if (!nearness) return std::unexpected(nearness.error());
    light.reflection_probes.nearness = unpack_nearness(*nearness);
    for (LightLayer& layer : light.layers) {
        const auto texels = reader.take_part(bytes_of_light_texel * static_cast<std::size_t>(light.size.pixels()));
        if (!texels) return std::unexpected(texels.error());
        layer.texels = unpack_light_texels(*texels);
        const auto probes = reader.take_part(light.grid.size() * bytes_of_light_probe);
        if (!probes) return std::unexpected(probes.error());
        layer.probes = unpack_light_probes(*probes);
        const auto seen = reader.take_part(bytes_of_light_texel * texels_of_reflections(reflections));
        if (!seen) return std::unexpected(seen.error());
        layer.reflections = unpack_light_texels(*seen, mirror_light_steps);
    }
    return {};
}

}  // namespace

std::vector<std::byte> encode_baked_light(const BakedLight& light) {
    Writer writer;
    writer.add(std::as_bytes(std::span(magic)));
    const std::string header = baked_light_header(light).dump();
    writer.add_size(header.size());
    writer.add(std::as_bytes(std::span(header)));
    for (const BakedModel& model : light.models) {
        std::vector<std::byte> part;
        for (const BakedPrimitive& primitive : model.primitives) {
            append(primitive.vertices, part);
            append(primitive.coordinates, part);
            append(primitive.indices, part);
        }
        writer.add_part(part);
    }
    writer.add_part(bytes_of(light.grid.is_open));
    writer.add_part(pack_nearness(light.reflection_probes.nearness));
    for (const LightLayer& layer : light.layers) {
        writer.add_part(pack_light_texels(layer.texels));
        writer.add_part(pack_light_probes(layer.probes));
        writer.add_part(pack_light_texels(layer.reflections, mirror_light_steps));
    }
    return writer.take();
}

Result<BakedLightRef> decode_baked_light(std::span<const std::byte> bytes, const Scene& scene) {
    Reader reader(bytes);
    const auto begin = reader.take(magic.size());
    if (!begin || std::memcmp(begin->data(), magic.data(), magic.size()) != 0)
        return error(ErrorKind::invalid_argument, "is no light of this version of camrig");
    const auto size = reader.take_size();
    const auto text = size && *size <= max_header_bytes ? reader.take(*size) : reader.take(bytes.size() + 1);
    if (!text) return std::unexpected(text.error());
    const auto header = parse_json({reinterpret_cast<const char*>(text->data()), text->size()}, max_header_bytes);
    if (!header) return std::unexpected(header.error());
    auto told = read_baked_light_header(*header, scene);
    if (!told) return std::unexpected(told.error());
    auto light = std::make_shared<BakedLight>(std::move(told->light));
    if (auto read = read_cuts(reader, told->cuts, scene, *light); !read) return std::unexpected(read.error());
    if (auto read = read_layers(reader, *light); !read) return std::unexpected(read.error());
    if (!reader.is_at_end()) return error(ErrorKind::invalid_argument, "goes on after its end");
    return light;
}

Result<BakedLightRef> read_baked_light(const std::filesystem::path& file, const Scene& scene) {
    try {
        return decode_baked_light(gltf::read_file(file, max_baked_light_bytes), scene);
    } catch (const gltf::Failure& failure) {
        return std::unexpected(failure.error);
    }
}

std::vector<std::filesystem::path> baked_light_files(const Scene& scene, const std::filesystem::path& scene_file) {
    std::vector<std::filesystem::path> files{scene_file};
    files.insert(files.end(), scene.bases.begin(), scene.bases.end());
    for (std::filesystem::path& file : files) file.replace_extension(baked_light_ending);
    std::erase_if(files, [](const std::filesystem::path& file) {
        std::error_code problem;
        return !std::filesystem::is_regular_file(file, problem);
    });
    return files;
}

void find_baked_light(Scene& scene, const std::filesystem::path& scene_file) {
    for (const std::filesystem::path& file : baked_light_files(scene, scene_file)) {
        const auto light = read_baked_light(file, scene);
        if (light) return use_baked_light(scene, *light);
        spdlog::warn("{}: {}; the scene looks as without it. camrig bake {} makes it anew", file.string(),
                     light.error().message, scene_file.string());
    }
}

}  // namespace camrig::world
