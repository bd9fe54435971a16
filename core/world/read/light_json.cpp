#include "core/world/read/light_json.h"

#include "core/world/read/daylight_json.h"
#include "core/world/world_fields.h"

namespace camrig::world {
namespace {

/// The sky and the ground, an object of their own.
FieldOf<Environment> ambient() {
    static const std::vector<FieldOf<Environment>> parts{
        color_at<&Environment::ambient_sky>({.name = "sky", .doc = "from above"}),
        color_at<&Environment::ambient_ground>({.name = "ground", .doc = "from below"})};
    FieldOf<Environment> entry{
        .field = {.name = "ambient",
                  .type = "object",
                  .doc = "light from everywhere: `sky` from above, `ground` from below; between "
                         "them it changes with the normal",
                  .fallback = "{\"sky\": " + parts[0].field.fallback + ", \"ground\": " + parts[1].field.fallback + "}",
                  .parts = descriptions_of(parts)}};
    entry.read = [](JsonReader& reader, Changes<Environment>& changes) {
        const nlohmann::json* const json = reader.find("ambient");
        if (!json) return;
        JsonReader nested(*json, reader.path_of("ambient"));
        read_fields(parts, nested, changes);
        if (auto done = nested.finish(); !done) reader.fail(done.error());
    };
    return entry;
}

/// Its strength in a unit; the scene's reader divides it by the lux that are white.
FieldOf<Light> in_unit(std::string name, std::string doc, std::string unit) {
    return field_at<&Light::intensity>({.name = std::move(name),
                                        .doc = std::move(doc),
                                        .unit = std::move(unit),
                                        .fallback = "by `intensity`",
                                        .range = {0.0, 1e12}});
}

std::vector<FieldOf<Light>> light_fields(LightType type) {
    const bool is_placed = type != LightType::directional, is_directed = type != LightType::point;
    std::vector<FieldOf<Light>> table{
        name_at<&Light::name>({.name = "name", .required = true}), color_at<&Light::color>({.name = "color"}),
        field_at<&Light::intensity>({.name = "intensity",
                                     .doc = "a white surface that faces a directional light of 1 is white at exposure "
                                            "1; point and spot: at 1 m",
                                     .range = {0.0, 1e9}})};
    table.push_back(in_unit(is_placed ? "candela" : "lux",
                            is_placed ? "instead of intensity, where the scene has a unit (see units)"
                                      : "instead of intensity, where the scene has a unit (see units): on a surface "
                                        "that faces it",
                            is_placed ? "cd" : "lx"));
    if (is_placed) {
        table.push_back(name_at<&Light::group>({.name = "group",
                                                .doc = "any name: of lamps that are switched as one, by this name, and "
                                                       "have one colour and intensity; bakes as one light",
                                                .fallback = "none"}));
        table.push_back(vector_at<&Light::position>({.name = "position", .required = true}));
        table.push_back(field_at<&Light::range>(
            {.name = "range", .doc = "fades to nothing there; 0: unlimited", .unit = "m", .range = {0.0, 1e9}}));
    }
    if (is_directed) {
        table.push_back(entry_by<&Light::direction>({.name = "direction",
                                                     .type = "[x, y, z]",
                                                     .doc = "the way the light travels; any length but 0",
                                                     .required = true,
                                                     .schema = R"({"$ref": "#/$defs/direction"})"},
                                                    [](JsonReader& reader, std::string_view key, glm::dvec3& out) {
                                                        read_vector(reader, key, out);
                                                        const double length = glm::length(out);
                                                        if (reader.ok(key) && !(length > 1e-9))
                                                            reader.fail(key, "has no length");
                                                        out /= length;
                                                    }));
    }
    table.push_back(field_at<&Light::flicker_depth>(
        {.name = "flicker_depth",
         .doc = "of a lamp on the mains: its light swings by this share of it, for cameras with a sensor",
         .range = {0.0, 1.0}}));
    table.push_back(field_at<&Light::flicker_hz>(
        {.name = "flicker_hz", .doc = "so often: twice the mains' frequency", .unit = "Hz", .range = {1.0, 1000.0}}));
    if (type == LightType::spot) {
        table.push_back(degrees_at<&Light::inner_cone_rad>(
            {.name = "inner_cone_deg", .doc = "half angle", .fallback = "0", .range = {0.0, 90.0}}));
        table.push_back(degrees_at<&Light::outer_cone_rad>({.name = "outer_cone_deg",
                                                            .doc = "half angle, over the inner one",
                                                            .fallback = "45",
                                                            .range = {0.0, 90.0}}));
    }
    return table;
}

void check_light_keys(const Light& light, JsonReader& reader) {
    const char* const in_unit = light.type == LightType::directional ? "lux" : "candela";
    if (reader.has(in_unit) && reader.has("intensity")) reader.fail(in_unit, "give either it or intensity");
    if (light.type == LightType::point && reader.has("direction")) reader.fail("direction", "a point light has none");
    if (light.type == LightType::directional && reader.has("position"))
        reader.fail("position", "a directional light has none");
    if (light.type == LightType::spot && light.inner_cone_rad >= light.outer_cone_rad)
        reader.fail("outer_cone_deg", "must be over inner_cone_deg");
}

Kind<Light> light_kind(LightType type, std::string name, std::string doc) {
    Light initial;
    initial.type = type;
    std::string either = type == LightType::directional ? R"({"not": {"required": ["lux", "intensity"]}})"
                                                        : R"({"not": {"required": ["candela", "intensity"]}})";
    return kind_of<Light, Light>({.name = std::move(name), .doc = std::move(doc), .rule = std::move(either)},
                                 light_fields(type), check_light_keys, initial);
}

}  // namespace

FieldTable<FogSpec> fields_of(std::type_identity<FogSpec>) {
    static const std::vector<FieldOf<FogSpec>> table{
        field_at<&FogSpec::visibility_m>(
            {.name = "visibility_m",
             .doc = "meteorological visibility: at this distance 2 % of a contrast are left; 0: no fog",
             .required = true,
             .unit = "m",
             .range = {0.0, 1e9}}),
        color_at<&FogSpec::color>(
            {.name = "color", .doc = "of what is hidden altogether", .fallback = "the background"})};
    return table;
}

Result<FogSpec> read_fog(const nlohmann::json& value, const std::string& path) {
    return read_all<FogSpec>(value, path);
}

FieldTable<Environment> fields_of(std::type_identity<Environment>) {
    static const std::vector<FieldOf<Environment>> table{
        color_at<&Environment::background>({.name = "background", .doc = "where nothing is"}),
        ambient(),
        field_at<&Environment::exposure>(
            {.name = "exposure", .doc = "factor on linear colour before the sRGB curve", .range = {1e-6, 1e6}}),
        field_at<&Environment::glow>(
            {.name = "glow",
             .doc = "what is unlit or emissive lights others as if it were so many times brighter "
                    "than it is drawn; counts where there is baked light (`camrig bake`)",
             .range = {0.0, 1e6}}),
        field_at<&Environment::lux>({.name = "lux",
                                     .doc = "for cameras with a sensor: illuminance where white is drawn as white",
                                     .unit = "lx",
                                     .range = {1e-4, 1e6},
                                     .null = "white fills their wells in 10 ms"}),
        nested_at<&Environment::daylight>({.name = "daylight",
                                           .doc = "sun and sky make the ambient light, the background and the light "
                                                  "`sun`, see daylight",
                                           .fallback = "none",
                                           .schema = R"({"$ref": "#/$defs/daylight"})"},
                                          read_daylight),
        nested_at<&Environment::fog>({.name = "fog",
                                      .doc = "hides what is far away, see fog",
                                      .fallback = "none",
                                      .schema = R"({"$ref": "#/$defs/fog"})"},
                                     read_fog)};
    return table;
}

const std::vector<Kind<Light>>& light_kinds() {
    static const std::vector<Kind<Light>> kinds{
        light_kind(LightType::directional, "directional", "the sun: from one direction, everywhere"),
        light_kind(LightType::point, "point", "from a point to all sides"),
        light_kind(LightType::spot, "spot", "from a point into a cone")};
    return kinds;
}

}  // namespace camrig::world
