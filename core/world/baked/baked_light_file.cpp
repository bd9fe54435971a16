#include "core/world/baked/baked_light_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <string>

#include <glm/gtc/packing.hpp>
#include <libdeflate.h>
#include <spdlog/spdlog.h>

#include "core/base/json_reader.h"
#include "core/base/portable_math.h"
#include "core/world/gltf/failure.h"
#include "core/world/gltf/resources.h"
#include "core/world/scene_reader.h"

namespace camrig::world {
namespace {

using nlohmann::json;

// A line, the length of a JSON text, the text, and then parts that are compressed each by itself: cuts of the models
// that are cut, which probes are open, and of each layer its texels and its probes.
constexpr std::string_view magic = "camrig light 1\n";
constexpr std::size_t max_header_bytes = std::size_t{16} << 20;
constexpr std::size_t max_part_bytes = std::size_t{512} << 20;
constexpr std::array<const char*, 4> source_names{"sky", "ground", "glow", "lamp"};

/// Texels are kept as logarithms: 128 steps a doubling, so that a step is 1/180 of the value.
constexpr int steps_of_doubling = 128, least_doubling = -14, last_code = 128 * 30;

std::uint16_t code_of(float value) {
    if (!(value > 0.0f)) return 0;
    const double at =
        (portable::log(static_cast<double>(value)) / std::numbers::ln2 - least_doubling) * steps_of_doubling + 1.0;
    return static_cast<std::uint16_t>(std::clamp(std::lround(at), 0l, long{last_code}));
}
float value_of(std::uint16_t code) {
    if (code == 0) return 0.0f;
    return static_cast<float>(portable::exp(((code - 1.0) / steps_of_doubling + least_doubling) * std::numbers::ln2));
}

/// Differences are small where light is smooth: green to the texel on the left, red and blue to their green.
std::vector<std::byte> packed_texels(const LightLayer& layer) {
    const std::size_t count = layer.texels.size();
    std::vector<std::byte> bytes(6 * count);
    std::array<int, 3> last{};
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 value = glm::unpackF3x9_E1x5(layer.texels[i]);
        const int green = code_of(value.g);
        const std::array<int, 3> now{green, code_of(value.r) - green, code_of(value.b) - green};
        for (std::size_t c = 0; c < 3; ++c) {
            const int step = now[c] - last[c];
            const auto folded = static_cast<std::uint16_t>(step >= 0 ? 2 * step : -2 * step - 1);
            bytes[(2 * c) * count + i] = static_cast<std::byte>(folded & 0xFF);
            bytes[(2 * c + 1) * count + i] = static_cast<std::byte>(folded >> 8);
        }
        last = now;
    }
    return bytes;
}

void unpack_texels(std::span<const std::byte> bytes, LightLayer& layer) {
    static const std::vector<float> values = [] {
        std::vector<float> made;
        for (int code = 0; code <= last_code; ++code) made.push_back(value_of(static_cast<std::uint16_t>(code)));
        return made;
    }();
    const std::size_t count = bytes.size() / 6;
    layer.texels.resize(count);
    std::array<int, 3> last{};
    const auto value = [](int code) { return values[static_cast<std::size_t>(std::clamp(code, 0, last_code))]; };
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            const int folded = std::to_integer<int>(bytes[2 * c * count + i]) |
                               std::to_integer<int>(bytes[(2 * c + 1) * count + i]) << 8;
            last[c] += (folded & 1) == 0 ? folded / 2 : -(folded + 1) / 2;
            last[c] = std::clamp(last[c], -2 * last_code, 2 * last_code);
        }
        layer.texels[i] =
            glm::packF3x9_E1x5(glm::vec3(value(last[0] + last[1]), value(last[0]), value(last[0] + last[2])));
    }
}

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
    std::memcpy(to.data(), from.data(), count * sizeof(T));
    from = from.subspan(count * sizeof(T));
}

std::string hex(std::uint64_t value) {
    return fmt::format("{:016x}", value);
}

json size_json(ImageSize size) {
    return json::array({size.width, size.height});
}

json header_of(const BakedLight& light) {
    json header{{"key", hex(light.key)}, {"size", size_json(light.size)}};
    for (const LightLayer& layer : light.layers)
        header["layers"].push_back(
            {{"source", source_names[static_cast<std::size_t>(layer.source)]}, {"lamp", layer.lamp}});
    for (const BakedModel& model : light.models) {
        json primitives = json::array();
        for (const BakedPrimitive& primitive : model.primitives)
            primitives.push_back(json::array(
                {primitive.vertices.size(), primitive.indices.size(), primitive.size.width, primitive.size.height}));
        header["models"].push_back({{"name", model.name}, {"primitives", primitives}});
    }
    for (const BakedObject& object : light.objects) {
        json surfaces = json::array();
        for (const BakedSurface& surface : object.surfaces)
            surfaces.push_back(json::array({surface.node, surface.primitive, surface.x, surface.y}));
        header["objects"].push_back(
            {{"name", object.name},
             {"position", {object.position.x, object.position.y, object.position.z}},
             {"orientation", {object.orientation.x, object.orientation.y, object.orientation.z, object.orientation.w}},
             {"scale", object.scale},
             {"surfaces", surfaces}});
    }
    header["grid"] = {{"first", {light.grid.first.x, light.grid.first.y, light.grid.first.z}},
                      {"spacing_m", light.grid.spacing_m},
                      {"count", {light.grid.count.x, light.grid.count.y, light.grid.count.z}}};
    return header;
}

constexpr std::size_t floats_of_probe = 12;

std::vector<float> floats_of(const std::vector<LightProbe>& probes) {
    std::vector<float> made;
    for (const LightProbe& probe : probes) {
        for (glm::length_t c = 0; c < 3; ++c) made.push_back(probe.mean[c]);
        for (glm::length_t i = 0; i < 3; ++i)
            for (glm::length_t c = 0; c < 3; ++c) made.push_back(probe.along[i][c]);
    }
    return made;
}

std::vector<LightProbe> probes_of(const std::vector<float>& floats) {
    std::vector<LightProbe> made;
    for (std::size_t at = 0; at + floats_of_probe <= floats.size(); at += floats_of_probe) {
        LightProbe& probe = made.emplace_back();
        std::size_t i = at;
        for (glm::length_t c = 0; c < 3; ++c) probe.mean[c] = floats[i++];
        for (glm::length_t axis = 0; axis < 3; ++axis)
            for (glm::length_t c = 0; c < 3; ++c) probe.along[axis][c] = floats[i++];
    }
    return made;
}

/// A list of whole numbers from 0 to `most`.
bool are_counts(const json& list, std::size_t count, std::int64_t most) {
    return list.is_array() && list.size() == count && std::ranges::all_of(list, [&](const json& item) {
               return item.is_number_integer() && item.get<std::int64_t>() >= 0 && item.get<std::int64_t>() <= most;
           });
}

std::vector<const Primitive*> primitives_of(const Model& model) {
    std::vector<const Primitive*> made;
    for (const Mesh& mesh : model.meshes)
        for (const Primitive& primitive : mesh.primitives) made.push_back(&primitive);
    return made;
}

/// Reads the text; what it says is then there: lengths of all parts.
class HeaderReader {
public:
    HeaderReader(const json& header, const Scene& scene, BakedLight& light)
        : reader_(header, ""), scene_(scene), light_(light) {}

    Result<void> read() {
        std::string key;
        reader_.required("key", key);
        read_size();
        read_layers();
        read_models();
        read_objects();
        read_grid();
        if (auto done = reader_.finish(); !done) return done;
        light_.key = light_key(scene_);
        if (key != hex(light_.key))
            return error(ErrorKind::unsupported, "the scene's shapes or lamps are others since it was baked");
        return {};
    }

private:
    void read_size() {
        const json* const size = reader_.find("size");
        if (size == nullptr || !are_counts(*size, 2, max_light_map_side))
            return reader_.fail("size", "two whole numbers up to " + std::to_string(max_light_map_side));
        light_.size = {(*size)[0].get<int>(), (*size)[1].get<int>()};
    }
    void read_layers() {
        const auto items = reader_.array("layers", max_light_layers);
        for (std::size_t i = 0; i < items.size(); ++i) {
            JsonReader item(items[i], "layers[" + std::to_string(i) + "]");
            std::string source;
            std::uint64_t lamp = 0;
            item.required("source", source);
            item.required("lamp", lamp);
            if (auto done = item.finish(); !done) return reader_.fail(done.error());
            const auto known = std::ranges::find(source_names, source);
            if (known == source_names.end()) return reader_.fail("layers", "no source '" + source.substr(0, 40) + "'");
            LightLayer& layer = light_.layers.emplace_back();
            layer.source = static_cast<LightSource>(known - source_names.begin());
            layer.lamp = lamp;
            if (layer.source == LightSource::lamp && lamp >= scene_.lights.size())
                return reader_.fail("layers", "names a lamp that the scene does not have");
        }
    }
    void read_models() {
        const auto items = reader_.array("models", max_scene_models);
        for (std::size_t i = 0; i < items.size(); ++i) {
            JsonReader item(items[i], "models[" + std::to_string(i) + "]");
            BakedModel& model = light_.models.emplace_back();
            item.required("name", model.name);
            const auto known = scene_.models.find(model.name);
            if (item.ok() && known == scene_.models.end()) item.fail("name", "the scene has no such model");
            std::vector<const Primitive*> sources;
            if (item.ok()) sources = primitives_of(*known->second.model);
            const auto primitives = item.array("primitives", sources.size());
            for (const json& given : primitives) {
                if (!are_counts(given, 4, std::int64_t{1} << 30))
                    item.fail("primitives", "lists of four whole numbers");
                if (!item.ok()) break;
                BakedPrimitive& primitive = model.primitives.emplace_back();
                counts_.push_back({given[0].get<std::size_t>(), given[1].get<std::size_t>()});
                primitive.size = {given[2].get<int>(), given[3].get<int>()};
                if (primitive.size.width > light_.size.width || primitive.size.height > light_.size.height)
                    item.fail("primitives", "is larger than the map");
            }
            if (item.ok() && primitives.size() != sources.size())
                item.fail("primitives", "the model has another number of them");
            if (auto done = item.finish(); !done) return reader_.fail(done.error());
        }
    }
    void read_objects() {
        const auto items = reader_.array("objects", max_scene_objects);
        for (std::size_t i = 0; i < items.size(); ++i) {
            JsonReader item(items[i], "objects[" + std::to_string(i) + "]");
            BakedObject& object = light_.objects.emplace_back();
            item.required("name", object.name);
            std::array<double, 3> position{};
            std::array<double, 4> orientation{};
            item.required("position", position);
            item.required("orientation", orientation);
            item.required("scale", object.scale);
            object.position = {position[0], position[1], position[2]};
            object.orientation = {orientation[3], orientation[0], orientation[1], orientation[2]};
            const BakedModel* const model = item.ok() ? model_of(object.name) : nullptr;
            if (item.ok() && model == nullptr) item.fail("name", "the scene has no such object of a model in here");
            for (const json& given : item.array("surfaces", 1 << 20)) {
                if (!item.ok()) break;
                if (!are_counts(given, 4, 1 << 30)) {
                    item.fail("surfaces", "lists of four whole numbers");
                    break;
                }
                const BakedSurface surface{given[0].get<int>(), given[1].get<std::size_t>(),
                                           static_cast<std::uint16_t>(given[2].get<int>()),
                                           static_cast<std::uint16_t>(given[3].get<int>())};
                if (surface.primitive >= model->primitives.size()) {
                    item.fail("surfaces", "the model has no such primitive");
                    break;
                }
                const ImageSize size = model->primitives[surface.primitive].size;
                if (surface.x + size.width > light_.size.width || surface.y + size.height > light_.size.height ||
                    size.width == 0)
                    item.fail("surfaces", "does not lie in the map");
                object.surfaces.push_back(surface);
            }
            if (auto done = item.finish(); !done) return reader_.fail(done.error());
        }
    }
    const BakedModel* model_of(const std::string& object) const {
        const auto spec = std::ranges::find(scene_.objects, object, &ObjectSpec::name);
        if (spec == scene_.objects.end()) return nullptr;
        const auto model = std::ranges::find(light_.models, spec->model, &BakedModel::name);
        return model == light_.models.end() ? nullptr : &*model;
    }
    void read_grid() {
        const json* const given = reader_.find("grid");
        if (given == nullptr) return reader_.fail("grid", "is missing");
        JsonReader item(*given, "grid");
        std::array<double, 3> first{};
        item.required("first", first);
        item.required("spacing_m", light_.grid.spacing_m);
        const json* const count = item.find("count");
        if (item.ok() && !(light_.grid.spacing_m > 0.0)) item.fail("spacing_m", "must be over 0");
        if (count == nullptr || !are_counts(*count, 3, 4096)) {
            item.fail("count", "three whole numbers up to 4096");
        } else {
            for (glm::length_t i = 0; i < 3; ++i) light_.grid.count[i] = (*count)[static_cast<std::size_t>(i)];
            if (light_.grid.size() > max_light_probes) item.fail("count", "more probes than can be");
        }
        light_.grid.first = {first[0], first[1], first[2]};
        if (auto done = item.finish(); !done) reader_.fail(done.error());
    }

public:
    /// Of each primitive: vertices and indices.
    const std::vector<std::array<std::size_t, 2>>& counts() const { return counts_; }

private:
    JsonReader reader_;
    const Scene& scene_;
    BakedLight& light_;
    std::vector<std::array<std::size_t, 2>> counts_;
};

constexpr std::size_t bytes_of_vertex = sizeof(std::uint32_t) + sizeof(glm::vec2);

Result<void> read_cuts(Reader& reader, const std::vector<std::array<std::size_t, 2>>& counts, const Scene& scene,
                       BakedLight& light) {
    std::size_t number = 0;
    for (BakedModel& model : light.models) {
        std::size_t size = 0;
        for (std::size_t i = 0; i < model.primitives.size(); ++i)
            size += counts[number + i][0] * bytes_of_vertex + counts[number + i][1] * sizeof(std::uint32_t);
        const auto part = reader.take_part(size);
        if (!part) return std::unexpected(part.error());
        std::span<const std::byte> left(*part);
        const std::vector<const Primitive*> sources = primitives_of(*scene.models.at(model.name).model);
        for (std::size_t i = 0; i < model.primitives.size(); ++i, ++number) {
            BakedPrimitive& primitive = model.primitives[i];
            take_values(left, counts[number][0], primitive.vertices);
            take_values(left, counts[number][0], primitive.coordinates);
            take_values(left, counts[number][1], primitive.indices);
            const auto is_below = [](std::size_t limit) {
                return [limit](std::uint32_t value) { return value < limit; };
            };
            const auto is_inside = [&](const glm::vec2& at) {
                return at.x >= 0.0f && at.y >= 0.0f && at.x <= static_cast<float>(primitive.size.width) &&
                       at.y <= static_cast<float>(primitive.size.height);
            };
            if (!std::ranges::all_of(primitive.vertices, is_below(sources[i]->positions.size())) ||
                !std::ranges::all_of(primitive.indices, is_below(primitive.vertices.size())) ||
                !std::ranges::all_of(primitive.coordinates, is_inside) || primitive.indices.size() % 3 != 0 ||
                (primitive.size.width > 0 && primitive.indices.empty()))
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
    for (LightLayer& layer : light.layers) {
        const auto texels = reader.take_part(6 * static_cast<std::size_t>(light.size.pixels()));
        if (!texels) return std::unexpected(texels.error());
        unpack_texels(*texels, layer);
        const auto probes = reader.take_part(light.grid.size() * floats_of_probe * sizeof(float));
        if (!probes) return std::unexpected(probes.error());
        std::vector<float> floats;
        left = *probes;
        take_values(left, light.grid.size() * floats_of_probe, floats);
        if (!std::ranges::all_of(floats, [](float value) { return std::abs(value) < 1e9f; }))
            return error(ErrorKind::invalid_argument, "a probe is no number");
        layer.probes = probes_of(floats);
    }
    return {};
}

}  // namespace

std::vector<std::byte> encode_baked_light(const BakedLight& light) {
    Writer writer;
    writer.add(std::as_bytes(std::span(magic)));
    const std::string header = header_of(light).dump();
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
    for (const LightLayer& layer : light.layers) {
        writer.add_part(packed_texels(layer));
        writer.add_part(bytes_of(floats_of(layer.probes)));
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
    auto light = std::make_shared<BakedLight>();
    HeaderReader of_header(*header, scene, *light);
    if (auto read = of_header.read(); !read) return std::unexpected(read.error());
    if (auto read = read_cuts(reader, of_header.counts(), scene, *light); !read) return std::unexpected(read.error());
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

void find_baked_light(Scene& scene, const std::filesystem::path& scene_file) {
    std::filesystem::path file = scene_file;
    file.replace_extension(baked_light_ending);
    std::error_code problem;
    if (!std::filesystem::is_regular_file(file, problem)) return;
    const auto light = read_baked_light(file, scene);
    if (light) return use_baked_light(scene, *light);
    spdlog::warn("{}: {}; the scene looks as without it. camrig bake {} makes it anew", file.string(),
                 light.error().message, scene_file.string());
}

}  // namespace camrig::world
