#pragma once

#include <cmath>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/base/field_of.h"
#include "core/base/time.h"
#include "core/world/read/json_parts.h"

/// Entries of tables (core/base/field_of.h) for values of the world. $defs are those of scenes/schema.json.
namespace camrig {

inline constexpr double longest_s = 1e9;  // 31 years

/// The entry of a member, or of an optional one, that `get(reader, key, value)` reads when its key is there.
template <auto member, typename Get>
auto entry_by(Field field, Get get) {
    using Pointer = MemberPointer<decltype(member)>;
    using V = typename ValueOf<typename Pointer::Value>::type;
    FieldOf<typename Pointer::Struct> entry{.field = std::move(field)};
    entry.read = [field = entry.field, get](JsonReader& reader, Changes<typename Pointer::Struct>& changes) {
        if (!reader.find(field.name)) {
            if (field.required) reader.fail(field.name, "is missing");
            return;
        }
        V value{};
        get(reader, field.name, value);
        if (!reader.ok(field.name)) return;
        if constexpr (std::floating_point<V> || std::integral<V>) {
            if (auto problem = problem_of(field, *reader.find(field.name)))
                return reader.fail(field.name, problem->substr(2));
        }
        changes.change([value = std::move(value)](auto& target) { target.*member = value; });
    };
    return entry;
}

/// The name of something in the scene.
template <auto member>
auto name_at(Field field) {
    field.type = "string";
    field.schema = R"({"$ref": "#/$defs/name"})";
    return entry_by<member>(std::move(field), required_name);
}

/// A place or a velocity.
template <auto member>
auto vector_at(Field field) {
    field.type = "[x, y, z]";
    if (field.unit.empty()) field.unit = "m";
    field.schema = R"({"$ref": "#/$defs/point"})";
    return entry_by<member>(std::move(field), read_vector);
}

/// A member in nanoseconds, in JSON seconds.
template <auto member>
auto seconds_at(Field field) {
    field.type = "number";
    field.unit = "s";
    if (!field.range.has_low()) field.range.low = 0.0;
    if (!field.range.has_high()) field.range.high = longest_s;
    return entry_by<member>(field, [range = field.range](JsonReader& reader, std::string_view key, TimeNs& out) {
        double seconds = 0.0;
        reader.required(key, seconds);
        if (range.contains(seconds)) out = std::llround(seconds * 1e9);
    });
}

/// A member in radians, in JSON degrees.
template <auto member>
auto degrees_at(Field field) {
    field.type = "number";
    field.unit = "deg";
    return entry_by<member>(std::move(field), [](JsonReader& reader, std::string_view key, double& out) {
        reader.required(key, out);
        out = glm::radians(out);
    });
}

template <auto member>
auto color_at(Field field) {
    field.type = "[r, g, b]";
    field.schema = R"({"$ref": "#/$defs/color"})";
    return entry_by<member>(std::move(field), optional_color);
}

/// What is read from the JSON of the key by `read(json, path)`, which gives a Result.
template <auto member, typename Read>
auto nested_at(Field field, Read read) {
    field.type = "object";
    return entry_by<member>(std::move(field), [read](JsonReader& reader, std::string_view key, auto& out) {
        auto made = read(*reader.find(key), reader.path_of(key));
        if (made)
            out = std::move(*made);
        else
            reader.fail(made.error());
    });
}

/// Appends the two ways to say where something is turned: yaw_deg or orientation.
template <auto member, typename T>
void add_orientation(std::vector<FieldOf<T>>& table, const std::string& doc) {
    auto read = [](JsonReader& reader, Changes<T>& changes) {
        glm::dquat orientation(1.0, 0.0, 0.0, 0.0);
        if (read_orientation(reader, orientation))
            changes.change([orientation](T& target) { target.*member = orientation; });
    };
    table.push_back({.field = {.name = "yaw_deg", .type = "number", .doc = doc, .unit = "deg"}, .read = read});
    table.push_back({.field = {.name = "orientation",
                               .type = "[x, y, z, w]",
                               .doc = "instead of yaw_deg",
                               .schema = R"({"$ref": "#/$defs/quaternion"})"}});
}
/// JSON schema of that: one of the two.
inline constexpr const char* one_orientation = R"({"not": {"required": ["yaw_deg", "orientation"]}})";

/// The entries of a struct within a T, as if they were of the T.
template <auto member, typename T, typename Inner>
void add_inner(std::vector<FieldOf<T>>& table, const std::vector<FieldOf<Inner>>& inner) {
    for (const auto& entry : inner) {
        FieldOf<T> outer{.field = entry.field};
        if (entry.read)
            outer.read = [read = entry.read](JsonReader& reader, Changes<T>& changes) {
                Changes<Inner> own;
                read(reader, own);
                changes.change([own](T& target) { own.apply_to(target.*member); });
            };
        table.push_back(std::move(outer));
    }
}

}  // namespace camrig
