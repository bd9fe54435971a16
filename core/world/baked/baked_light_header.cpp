#include "core/world/baked/baked_light_header.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "core/base/json_reader.h"
#include "core/world/scene_reader.h"

namespace camrig::world {
namespace {

using nlohmann::json;

constexpr std::array<const char*, 4> source_names{"sky", "ground", "glow", "lamp"};

std::string hex(std::uint64_t value) {
    return fmt::format("{:016x}", value);
}

json size_json(ImageSize size) {
    return json::array({size.width, size.height});
}

/// A list of whole numbers from 0 to `most`.
bool are_counts(const json& list, std::size_t count, std::int64_t most) {
    return list.is_array() && list.size() == count && std::ranges::all_of(list, [&](const json& item) {
               return item.is_number_integer() && item.get<std::int64_t>() >= 0 && item.get<std::int64_t>() <= most;
           });
}

/// Reads the text; what it says is then there: lengths of all parts.
class HeaderReader {
public:
    HeaderReader(const json& header, const Scene& scene) : reader_(header, ""), scene_(scene) {}

    Result<BakedLightHeader> read() {
        std::string key;
        reader_.required("key", key);
        read_size();
        read_layers();
        read_models();
        read_objects();
        read_grid();
        read_reflection_probes();
        if (auto done = reader_.finish(); !done) return std::unexpected(done.error());
        light_.key = light_key(scene_);
        if (key != hex(light_.key))
            return error(ErrorKind::unsupported,
                         "the scene's shapes, materials or lamps are others since it was baked");
        return std::move(header_);
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
        if (static_cast<std::int64_t>(items.size()) * light_.size.pixels() > max_light_texels)
            return reader_.fail("layers", "more than " + std::to_string(max_light_texels) + " texels in all",
                                ErrorKind::resource_exhausted);
        for (std::size_t i = 0; i < items.size(); ++i) {
            JsonReader item(items[i], "layers[" + std::to_string(i) + "]");
            std::string source;
            item.required("source", source);
            const json* const lamps = item.find("lamps");
            if (lamps == nullptr || !lamps->is_array() ||
                !are_counts(*lamps, lamps->size(), static_cast<std::int64_t>(scene_.lights.size()) - 1))
                item.fail("lamps", "numbers of lights that the scene has");
            if (auto done = item.finish(); !done) return reader_.fail(done.error());
            const auto known = std::ranges::find(source_names, source);
            if (known == source_names.end()) return reader_.fail("layers", "no source '" + source.substr(0, 40) + "'");
            LightLayer& layer = light_.layers.emplace_back();
            layer.source = static_cast<LightSource>(known - source_names.begin());
            for (const json& lamp : *lamps) layer.lamps.push_back(lamp.get<std::size_t>());
            if ((layer.source == LightSource::lamp) == layer.lamps.empty())
                return reader_.fail("layers", "those of lamps, and no others, name some");
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
                header_.cuts.push_back({given[0].get<std::size_t>(), given[1].get<std::size_t>()});
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
            if (model != nullptr) object.model = model->name;
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
            if (!std::ranges::is_sorted(object.surfaces, is_before)) item.fail("surfaces", "are not in their order");
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
            if (light_.grid.size() * light_.layers.size() > max_light_probes)
                item.fail("count", "more than " + std::to_string(max_light_probes) + " probes in all layers",
                          ErrorKind::resource_exhausted);
        }
        light_.grid.first = {first[0], first[1], first[2]};
        if (auto done = item.finish(); !done) reader_.fail(done.error());
    }

    void read_reflection_probes() {
        for (const json& given : reader_.array("reflection_probes", max_reflection_probes)) {
            const auto is_coordinate = [](const json& item) {
                return item.is_number() && std::abs(item.get<double>()) < 1e9;
            };
            if (!given.is_array() || given.size() != 3 || !std::ranges::all_of(given, is_coordinate))
                return reader_.fail("reflection_probes", "places [x, y, z]");
            light_.reflection_probes.places.emplace_back(given[0].get<float>(), given[1].get<float>(),
                                                         given[2].get<float>());
        }
    }

    JsonReader reader_;
    const Scene& scene_;
    BakedLightHeader header_;
    BakedLight& light_ = header_.light;
};

}  // namespace

std::vector<const Primitive*> primitives_of(const Model& model) {
    std::vector<const Primitive*> made;
    for (const Mesh& mesh : model.meshes)
        for (const Primitive& primitive : mesh.primitives) made.push_back(&primitive);
    return made;
}

json baked_light_header(const BakedLight& light) {
    json header{{"key", hex(light.key)}, {"size", size_json(light.size)}};
    for (const LightLayer& layer : light.layers)
        header["layers"].push_back(
            {{"source", source_names[static_cast<std::size_t>(layer.source)]}, {"lamps", layer.lamps}});
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
    header["reflection_probes"] = json::array();
    for (const glm::vec3& place : light.reflection_probes.places)
        header["reflection_probes"].push_back({place.x, place.y, place.z});
    return header;
}

Result<BakedLightHeader> read_baked_light_header(const json& text, const Scene& scene) {
    return HeaderReader(text, scene).read();
}

}  // namespace camrig::world
