#include "core/world/read/light_json.h"

#include "core/world/read/json_parts.h"

namespace camrig {

using nlohmann::json;

namespace {

void read_direction(JsonReader& reader, glm::dvec3& out) {
    if (!read_vector(reader, "direction", out)) return reader.fail("direction", "is missing");
    const double length = glm::length(out);
    if (!(length > 1e-9)) return reader.fail("direction", "has no length");
    out /= length;
}

}  // namespace

Result<Environment> read_environment(const json& value, std::string path) {
    Environment environment;
    JsonReader reader(value, std::move(path));
    optional_color(reader, "background", environment.background);
    if (const json* ambient = reader.find("ambient")) {
        JsonReader nested(*ambient, reader.path_of("ambient"));
        optional_color(nested, "sky", environment.ambient_sky);
        optional_color(nested, "ground", environment.ambient_ground);
        if (auto done = nested.finish(); !done) reader.fail(done.error());
    }
    double exposure = 1.0;
    optional_in_range(reader, "exposure", exposure, 1e-6, 1e6);
    environment.exposure = static_cast<float>(exposure);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return environment;
}

Result<Light> read_light(const json& value, std::string path) {
    JsonReader reader(value, std::move(path));
    Light light;
    std::string type;
    required_name(reader, "name", light.name);
    reader.required("type", type);
    optional_color(reader, "color", light.color);
    double intensity = 1.0, range = 0.0, inner_deg = 0.0, outer_deg = 45.0;
    optional_in_range(reader, "intensity", intensity, 0.0, 1e9);
    const bool placed = type == "point" || type == "spot";
    if (type == "directional")
        light.type = LightType::directional;
    else if (type == "spot")
        light.type = LightType::spot;
    else if (type == "point")
        light.type = LightType::point;
    else {
        reader.allow_unknown();
        if (reader.ok("type")) reader.fail("type", "'" + type.substr(0, 40) + "' is none of directional, point, spot");
        if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    }
    if (placed) {
        if (!read_vector(reader, "position", light.position)) reader.fail("position", "is missing");
        optional_in_range(reader, "range", range, 0.0, 1e9);
    }
    if (light.type == LightType::spot) {
        optional_in_range(reader, "inner_cone_deg", inner_deg, 0.0, 90.0);
        optional_in_range(reader, "outer_cone_deg", outer_deg, 0.0, 90.0);
        if (reader.ok() && inner_deg >= outer_deg) reader.fail("outer_cone_deg", "must be over inner_cone_deg");
    }
    if (light.type != LightType::point) {
        read_direction(reader, light.direction);
    } else if (reader.has("direction")) {
        reader.fail("direction", "a point light has none");
    }
    if (light.type == LightType::directional && reader.has("position"))
        reader.fail("position", "a directional light has none");
    light.intensity = static_cast<float>(intensity);
    light.range = static_cast<float>(range);
    light.inner_cone_rad = static_cast<float>(glm::radians(inner_deg));
    light.outer_cone_rad = static_cast<float>(glm::radians(outer_deg));
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return light;
}

}  // namespace camrig
