#include "core/camera/ptz_spec.h"

#include "core/base/field_of.h"

namespace camrig::camera {
namespace {

using S = PtzSpec;

/// A pair of numbers, the first at most the second.
template <auto member>
FieldOf<S> limits_at(Field given, bool may_be_null) {
    FieldOf<S> entry;
    entry.field = std::move(given);
    entry.field.type = "array of numbers";
    if (may_be_null) entry.field.type += " or null";
    entry.field.schema = R"({"type": ["array", "null"], "items": {"type": "number", "minimum": -180, "maximum": 180},
        "minItems": 2, "maxItems": 2})";
    entry.read = [field = entry.field, may_be_null](JsonReader& reader, Changes<S>& changes) {
        if (may_be_null && reader.has_null(field.name)) {
            if constexpr (is_optional<std::remove_cvref_t<decltype(S{}.*member)>>)
                return changes.change([](S& s) { (s.*member).reset(); });
        }
        const nlohmann::json* const json = reader.find(field.name);
        if (!json) return;
        const bool is_pair = json->is_array() && json->size() == 2 && (*json)[0].is_number() && (*json)[1].is_number();
        const PtzLimits limits = is_pair ? PtzLimits{(*json)[0], (*json)[1]} : PtzLimits{1.0, 0.0};
        if (!(limits.low <= limits.high && limits.low >= -180.0 && limits.high <= 180.0))
            return reader.fail(field.name, "must be two angles from -180 to 180, the lower first");
        changes.change([limits](S& s) { s.*member = limits; });
    };
    entry.write = [](const S& from) {
        const std::optional<PtzLimits> limits = from.*member;
        return limits ? nlohmann::json{limits->low, limits->high} : nlohmann::json(nullptr);
    };
    return entry;
}

FieldOf<S> preset() {
    FieldOf<S> entry =
        field_at<&S::preset>({.name = "preset", .doc = "figures of a kind of head; what is given beside it counts"});
    entry.read = [field = entry.field](JsonReader& reader, Changes<S>& changes) {
        if (const auto value = read_value<PtzPreset>(reader, field))
            changes.change([preset = *value](S& s) {
                const std::uint64_t seed = s.seed;
                s = ptz_preset(preset);
                s.seed = seed;
            });
    };
    return entry;
}

}  // namespace

std::span<const Named<PtzPreset>> names_of(std::type_identity<PtzPreset>) {
    static constexpr Named<PtzPreset> names[] = {
        {PtzPreset::ideal, "ideal"}, {PtzPreset::dome, "dome"}, {PtzPreset::cheap, "cheap"}};
    return names;
}

PtzSpec ptz_preset(PtzPreset preset) {
    switch (preset) {
        case PtzPreset::ideal:
            return {.preset = preset,
                    .pan_limits_deg = std::nullopt,
                    .tilt_limits_deg = {-90.0, 90.0},
                    .speed_deg_s = 360.0,
                    .acceleration_deg_s2 = 3600.0,
                    .zoom_s = 0.5,
                    .latency_s = 0.0,
                    .stop_latency_s = 0.0,
                    .quantum_deg = 0.0,
                    .repeatability_deg = 0.0,
                    .is_proportional = false,
                    .flips = false};
        case PtzPreset::dome:
            return {};
        case PtzPreset::cheap:
            return {.preset = preset,
                    .pan_limits_deg = PtzLimits{-175.0, 175.0},
                    .tilt_limits_deg = {-90.0, 30.0},
                    .zoom_max = 13.0,
                    .speed_deg_s = 7.0,
                    .acceleration_deg_s2 = 30.0,
                    .zoom_s = 8.0,
                    .latency_s = 0.4,
                    .stop_latency_s = 0.8,
                    .quantum_deg = 0.1,
                    .repeatability_deg = 0.25,
                    .backlash_deg = 0.2,
                    .flips = false};
    }
    return {};
}

FieldTable<PtzSpec> fields_of(std::type_identity<PtzSpec>) {
    static const std::vector<FieldOf<S>> table{
        preset(),
        limits_at<&S::pan_limits_deg>({.name = "pan_limits_deg",
                                       .doc = "[low, high] from `pose`, positive to the left",
                                       .unit = "deg",
                                       .fallback = "null",
                                       .null = "it turns without end"},
                                      true),
        limits_at<&S::tilt_limits_deg>({.name = "tilt_limits_deg",
                                        .doc = "[low, high] from `pose`, positive upwards",
                                        .unit = "deg",
                                        .fallback = "[-90, 20]"},
                                       false),
        field_at<&S::zoom_max>(
            {.name = "zoom_max", .doc = "focal length at the long end, of that at the wide end", .range = {1, 100}}),
        field_at<&S::speed_deg_s>(
            {.name = "speed_deg_s", .doc = "of pan and of tilt, at most", .unit = "deg/s", .range = {0.01, 10'000}}),
        field_at<&S::acceleration_deg_s2>(
            {.name = "acceleration_deg_s2", .doc = "of both", .unit = "deg/s2", .range = {0.01, 1e6}}),
        field_at<&S::zoom_s>(
            {.name = "zoom_s", .doc = "from one end of the zoom to the other", .unit = "s", .range = {0.01, 60}}),
        field_at<&S::latency_s>(
            {.name = "latency_s", .doc = "from a command to the begin of its motion", .unit = "s", .range = {0, 10}}),
        field_at<&S::stop_latency_s>(
            {.name = "stop_latency_s", .doc = "from a stop to the begin of braking", .unit = "s", .range = {0, 10}}),
        field_at<&S::quantum_deg>(
            {.name = "quantum_deg", .doc = "of the angles that it tells", .unit = "deg", .range = {0, 10}}),
        field_at<&S::repeatability_deg>({.name = "repeatability_deg",
                                         .doc = "it stops at most so far from where it believes to be",
                                         .unit = "deg",
                                         .range = {0, 10}}),
        field_at<&S::backlash_deg>({.name = "backlash_deg",
                                    .doc = "play of its gears: where it stops depends on where it comes from",
                                    .unit = "deg",
                                    .range = {0, 10}}),
        field_at<&S::is_proportional>(
            {.name = "proportional", .doc = "relative and continuous moves are slower by the zoom"}),
        field_at<&S::flips>(
            {.name = "flip",
             .doc = "past straight up or down the picture is turned over and relative and continuous tilt with it"}),
        field_at<&S::seed>({.name = "seed", .doc = "of where it stops", .range = {.low = 0}}),
    };
    return table;
}

}  // namespace camrig::camera
