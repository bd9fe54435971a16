#include "core/world/read/model_json.h"

#include "core/base/error_list.h"
#include "core/world/shipped.h"
#include "core/world/turn.h"
#include "core/world/world_fields.h"

namespace camrig::world {

using nlohmann::json;

std::span<const Named<ModelFile::Front>> names_of(std::type_identity<ModelFile::Front>) {
    using enum ModelFile::Front;
    static constexpr Named<ModelFile::Front> names[] = {
        {plus_x, "+x"}, {minus_x, "-x"}, {plus_z, "+z"}, {minus_z, "-z"}};
    return names;
}

namespace {

constexpr double least_size_m = 1e-3, most_size_m = 1e5;

/// Turns the z-up model so that what is its front in glTF's frame looks along +x.
glm::dquat heading_from(ModelFile::Front front) {
    constexpr double degrees[] = {0.0, 180.0, 90.0, -90.0};  // glTF +z is -y in the z-up frame
    return turned_to(glm::radians(degrees[static_cast<std::size_t>(front)]));
}

FieldOf<ModelFile> front_field() {
    return field_at<&ModelFile::front>(
        {.name = "front", .doc = "the axis of the file (y up) that points ahead when an actor moves the model"});
}

template <auto member>
auto size_at() {
    constexpr bool is_flat = std::same_as<typename MemberPointer<decltype(member)>::Value, glm::dvec2>;
    return entry_by<member>(
        {.name = "size",
         .type = is_flat ? "[x, y]" : "[x, y, z]",
         .doc = "0.001 to 100000",
         .unit = "m",
         .fallback = vector_fallback<member>(),
         .schema = is_flat ? R"({"$ref": "#/$defs/plane_size"})" : R"({"$ref": "#/$defs/box_size"})"},
        [](JsonReader& reader, std::string_view key, auto& out) {
            reader.required(key, std::span<double>(&out[0], static_cast<std::size_t>(out.length())));
            for (glm::length_t i = 0; i < out.length(); ++i)
                if (reader.ok(key) && !(out[i] >= least_size_m && out[i] <= most_size_m))
                    reader.fail(key, "expected metres from 0.001 to 100000");
        });
}

template <auto member>
auto roughness_at() {
    return field_at<member>({.name = "roughness", .range = {0.0, 1.0}});
}

template <typename T>
Kind<Shape> shape_kind(std::string name, std::string doc, const std::vector<FieldOf<T>>& table) {
    auto kind = kind_of<Shape, T>({.name = std::move(name), .doc = std::move(doc)}, table);
    kind.description.fields.push_back(front_field().field);
    return kind;
}

}  // namespace

FieldTable<ModelFile> fields_of(std::type_identity<ModelFile>) {
    static const std::vector<FieldOf<ModelFile>> table{
        field_at<&ModelFile::file>(
            {.name = "file",
             .doc = ".glb or .gltf, relative to the scene file, in its folder or below, no `..`; or `camrig:` and the "
                    "name of a [shipped model](scenes.md#models): `camrig:people/anna`, `camrig:street/van.glb`",
             .required = true,
             .schema = R"({"$ref": "#/$defs/model_path"})"}),
        front_field(),
        field_at<&ModelFile::photometric>(
            {.name = "photometric",
             .doc = "what its materials emit is in cd/m2 and its lights are in cd and lx, as glTF has them; for scenes "
                    "with a unit, see units"})};
    return table;
}

const std::vector<Kind<Shape>>& shape_kinds() {
    static const std::vector<Kind<Shape>> kinds{
        shape_kind<GroundShape>(
            "ground",
            "a level rectangle about its origin, seen from above, with a grid of lines and lighter "
            "and darker cells that shows scale and motion",
            {size_at<&GroundShape::size>(), color_at<&GroundShape::color>({.name = "color"}),
             roughness_at<&GroundShape::roughness>(),
             field_at<&GroundShape::grid_m>({.name = "grid_m",
                                             .doc = "side of a cell; every tenth line is bolder. 0: no grid",
                                             .unit = "m",
                                             .range = {0.0, most_size_m}})}),
        shape_kind<BoxShape>("box", "a box that stands on its origin: the middle of its bottom",
                             {size_at<&BoxShape::size>(), color_at<&BoxShape::color>({.name = "color"}),
                              roughness_at<&BoxShape::roughness>()}),
        shape_kind<SkyShape>(
            "sky", "a sphere about its origin, seen from within, that shines by itself; it casts no shadow",
            {field_at<&SkyShape::radius_m>({.name = "radius_m", .unit = "m", .range = {least_size_m, most_size_m}}),
             color_at<&SkyShape::color>({.name = "color", .doc = "above"}),
             color_at<&SkyShape::horizon>({.name = "horizon", .doc = "level and below"})})};
    return kinds;
}

Result<ModelRef> ModelReader::load(const std::string& file) {
    if (const auto found = loaded_.find(file); found != loaded_.end()) return found->second;
    std::filesystem::path path = folder_ / file;
    if (file.starts_with(shipped_prefix)) {
        auto shipped = find_shipped_model(std::string_view(file).substr(shipped_prefix.size()));
        if (!shipped) return std::unexpected(shipped.error());
        path = std::move(*shipped);
    } else if (!leads_below(file)) {
        return error(ErrorKind::invalid_argument,
                     "must be a path below the scene file's folder, or camrig: and the name of a shipped model");
    }
    const ErrorList::Pause paths_of_another_file;
    auto model = source_(path);
    if (model) loaded_.emplace(file, *model);
    return model;
}

Result<SceneModel> ModelReader::read(const json& value, const std::string& path) {
    JsonReader reader(value, path);
    const bool is_shape = reader.has("shape");
    if (is_shape && reader.has("file")) reader.fail("file", "give either file or shape");
    Changes<ModelFile> changes;
    for (const auto& entry : fields_of(std::type_identity<ModelFile>{}))
        if (!is_shape || entry.field.name == "front") entry.read(reader, changes);
    ModelFile file;
    changes.apply_to(file);
    SceneModel made{.model = {}, .heading_from_model = heading_from(file.front), .is_photometric = file.photometric};
    if (is_shape) {
        const Shape shape = read_kind(shape_kinds(), reader, "shape");
        if (auto done = reader.finish(); !done) return std::unexpected(done.error());
        made.model = shape_model(shape);
        return made;
    }
    if (reader.ok("file") && reader.find("file")) {
        auto model = load(file.file);
        if (model)
            made.model = *model;
        else
            reader.fail("file", model.error().message, model.error().kind);
    }
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return made;
}

}  // namespace camrig::world
