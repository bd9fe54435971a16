#include "core/world/read/model_json.h"

#include <optional>

#include "core/base/error_list.h"
#include "core/world/read/json_parts.h"
#include "core/world/shape_model.h"
#include "core/world/shipped.h"
#include "core/world/turn.h"

namespace camrig {

using nlohmann::json;

namespace {

constexpr double least_size_m = 1e-3, most_size_m = 1e5;

/// Turns the z-up model so that what is its front in glTF's frame looks along +x.
std::optional<glm::dquat> heading_from_front(std::string_view front) {
    const auto about_z = [](double deg) { return turned_to(glm::radians(deg)); };
    if (front == "+z") return about_z(90.0);  // glTF +z is -y in the z-up frame
    if (front == "-z") return about_z(-90.0);
    if (front == "+x") return glm::dquat(1.0, 0.0, 0.0, 0.0);
    if (front == "-x") return about_z(180.0);
    return std::nullopt;
}

template <typename Vector>
void optional_size(JsonReader& reader, Vector& out) {
    if (!reader.has("size")) return;
    reader.required("size", std::span<double>(&out[0], static_cast<std::size_t>(Vector::length())));
    for (glm::length_t i = 0; i < Vector::length(); ++i)
        if (reader.ok("size") && !(out[i] >= least_size_m && out[i] <= most_size_m))
            reader.fail("size", "expected metres from 0.001 to 100000");
}

template <typename Solid>
void optional_surface(JsonReader& reader, Solid& solid) {
    optional_color(reader, "color", solid.color);
    double roughness = solid.roughness;
    optional_in_range(reader, "roughness", roughness, 0.0, 1.0);
    solid.roughness = static_cast<float>(roughness);
}

Shape read_shape(JsonReader& reader, const std::string& name) {
    if (name == "ground") {
        GroundShape ground;
        optional_size(reader, ground.size);
        optional_surface(reader, ground);
        optional_in_range(reader, "grid_m", ground.grid_m, 0.0, most_size_m);
        return ground;
    }
    if (name == "box") {
        BoxShape box;
        optional_size(reader, box.size);
        optional_surface(reader, box);
        return box;
    }
    SkyShape sky;
    if (name == "sky") {
        optional_in_range(reader, "radius_m", sky.radius_m, least_size_m, most_size_m);
        optional_color(reader, "color", sky.color);
        optional_color(reader, "horizon", sky.horizon);
        return sky;
    }
    reader.allow_unknown();
    if (reader.ok("shape")) reader.fail("shape", "'" + name.substr(0, 40) + "' is none of ground, box, sky");
    return sky;
}

/// Whether the path stays in the folder it is put behind.
bool leads_below(const std::string& file) {
    const std::filesystem::path path(file);
    bool inside = path.is_relative() && !file.empty() && file.find('\0') == std::string::npos;
    for (const auto& part : path) inside = inside && part != "..";
    return inside;
}

}  // namespace

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
    std::string front = "+z", file, shape;
    reader.optional("front", front);
    const auto heading = heading_from_front(front);
    if (reader.ok("front") && !heading) reader.fail("front", "'" + front.substr(0, 40) + "' is none of +x, -x, +z, -z");
    SceneModel made;
    if (heading) made.heading_from_model = *heading;
    if (reader.has("shape")) {
        if (reader.has("file")) reader.fail("file", "give either file or shape");
        reader.required("shape", shape);
        const Shape parts = read_shape(reader, shape);
        if (auto done = reader.finish(); !done) return std::unexpected(done.error());
        made.model = shape_model(parts);
        return made;
    }
    if (reader.required("file", file); reader.ok("file")) {
        auto model = load(file);
        if (model)
            made.model = *model;
        else
            reader.fail("file", model.error().message, model.error().kind);
    }
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return made;
}

}  // namespace camrig
