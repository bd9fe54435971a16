#include "core/world/read/daylight_json.h"

#include "core/daylight/sun.h"
#include "core/world/world_fields.h"

namespace camrig::world {
namespace {

void read_time(JsonReader& reader, std::string_view key, std::string& out) {
    reader.required(key, out);
    if (!reader.ok(key)) return;
    if (const auto instant = daylight::read_instant(out); !instant) reader.fail(key, instant.error().message);
}

}  // namespace

FieldTable<DaylightSpec> fields_of(std::type_identity<DaylightSpec>) {
    static const std::vector<FieldOf<DaylightSpec>> table{
        degrees_at<&DaylightSpec::azimuth_rad>({.name = "azimuth_deg",
                                                .doc = "of the sun, from north through east; with `elevation_deg`",
                                                .fallback = "by `time`",
                                                .range = {-360.0, 360.0}}),
        degrees_at<&DaylightSpec::elevation_rad>({.name = "elevation_deg",
                                                  .doc = "of the sun, over the horizon",
                                                  .fallback = "by `time`",
                                                  .range = {-90.0, 90.0}}),
        entry_by<&DaylightSpec::time>({.name = "time",
                                       .type = "string",
                                       .doc = "instead of angles: when, as `2026-06-21T14:30:00+02:00`",
                                       .fallback = "none"},
                                      read_time),
        field_at<&DaylightSpec::latitude_deg>(
            {.name = "latitude_deg", .doc = "north of the equator", .unit = "deg", .range = {-90.0, 90.0}}),
        field_at<&DaylightSpec::longitude_deg>(
            {.name = "longitude_deg", .doc = "east of Greenwich", .unit = "deg", .range = {-360.0, 360.0}}),
        degrees_at<&DaylightSpec::north_rad>(
            {.name = "north_deg", .doc = "from x counter-clockwise", .fallback = "90", .range = {-360.0, 360.0}}),
        field_at<&DaylightSpec::turbidity>(
            {.name = "turbidity", .doc = "of the air, Linke's: 2 is very clean, 10 haze", .range = {2.0, 10.0}}),
        field_at<&DaylightSpec::overcast>(
            {.name = "overcast", .doc = "1: the sky is all clouds, and there is no sun", .range = {0.0, 1.0}}),
        field_at<&DaylightSpec::clouds>(
            {.name = "clouds",
             .doc = "the share of the sky that clouds are, where a `sky` shape shows it; light is as `overcast` says",
             .fallback = "`overcast`",
             .range = {0.0, 1.0}}),
        color_at<&DaylightSpec::ground>({.name = "ground", .doc = "what the ground reflects of light"})};
    return table;
}

Result<DaylightSpec> read_daylight(const nlohmann::json& value, const std::string& path) {
    JsonReader reader(value, path);
    Changes<DaylightSpec> changes;
    read_fields(fields_of(std::type_identity<DaylightSpec>{}), reader, changes);
    DaylightSpec spec;
    changes.apply_to(spec);
    const bool has_time = reader.has("time");
    for (const char* angle : {"azimuth_deg", "elevation_deg"}) {
        if (has_time && reader.has(angle)) reader.fail(angle, "give either time or azimuth_deg and elevation_deg");
        if (!has_time && !reader.has(angle))
            reader.fail(angle, "is missing; or give time, latitude_deg and longitude_deg");
    }
    for (const char* place : {"latitude_deg", "longitude_deg"})
        if (reader.has(place) != has_time) reader.fail(place, has_time ? "is missing beside time" : "belongs to time");
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return spec;
}

}  // namespace camrig::world
