#pragma once

#include <cmath>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/base/field_of.h"
#include "core/base/number_text.h"
#include "core/base/time.h"

/// Values that scene files and commands share, and the entries of tables (core/base/field_of.h) for them. $defs are
/// those of scenes/schema.json.
namespace camrig::world {

inline constexpr std::size_t max_scene_name_bytes = 64;
inline constexpr double max_speed_m_s = 1000.0;
inline constexpr double longest_s = 1e9;  // 31 years

/// "objects[3]"
std::string item_path(std::string_view list, std::size_t index);
/// Names of things in a scene are free text that stays readable in messages and truth files.
bool is_scene_name(std::string_view name);

/// These read the value of a key that is there, and remember what is wrong in the reader.
void read_name(JsonReader& reader, std::string_view key, std::string& out);
void read_color(JsonReader& reader, std::string_view key, glm::vec3& out);
void read_vector(JsonReader& reader, std::string_view key, glm::dvec3& out);
/// "yaw_deg" (about z, counter-clockwise) or "orientation": [x, y, z, w]. Whether one of them was there.
bool read_orientation(JsonReader& reader, glm::dquat& out);

/// The items of a list, each read by `read(json, path)`, which gives a Result; none when the key is absent.
template <typename Item, typename Read>
std::vector<Item> read_items(JsonReader& reader, std::string_view key, std::size_t max_items, Read read) {
    std::vector<Item> items;
    const auto given = reader.array(key, max_items);
    for (std::size_t i = 0; i < given.size(); ++i) {
        if (auto item = read(given[i], item_path(reader.path_of(key), i)))
            items.push_back(std::move(*item));
        else
            reader.fail(item.error());
    }
    return items;
}

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
    return entry_by<member>(std::move(field), read_name);
}

/// Free text, of several lines if need be.
template <auto member>
auto text_at(Field field) {
    field.type = "string";
    return entry_by<member>(std::move(field), [](JsonReader& reader, std::string_view key, std::string& out) {
        reader.required(key, out);
    });
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
    return entry_by<member>(std::move(field), []<typename T>(JsonReader& reader, std::string_view key, T& out) {
        double degrees = 0.0;
        reader.required(key, degrees);
        out = static_cast<T>(glm::radians(degrees));
    });
}

/// What a vector is when it is not given, as documentation shows it: "[0.5, 0.5, 0.5]".
template <auto member>
std::string vector_fallback() {
    using Pointer = MemberPointer<decltype(member)>;
    if constexpr (is_optional<typename Pointer::Value>) {
        return {};
    } else {
        const auto value = typename Pointer::Struct{}.*member;
        std::string text;
        for (glm::length_t i = 0; i < value.length(); ++i) text += (i > 0 ? ", " : "[") + number_text(double(value[i]));
        return text + "]";
    }
}

template <auto member>
auto color_at(Field field) {
    field.type = "[r, g, b]";
    field.schema = R"({"$ref": "#/$defs/color"})";
    if (field.fallback.empty()) field.fallback = vector_fallback<member>();
    return entry_by<member>(std::move(field), read_color);
}

/// A list, each of whose items is read by `read(json, path)`, which gives a Result.
template <auto member, typename Read>
auto list_at(Field field, std::size_t max_items, Read read) {
    if (field.type.empty()) field.type = "array of objects";
    return entry_by<member>(std::move(field), [max_items, read](JsonReader& reader, std::string_view key, auto& out) {
        out = read_items<typename std::remove_cvref_t<decltype(out)>::value_type>(reader, key, max_items, read);
    });
}

/// What is read from the JSON of the key by `read(json, path)`, which gives a Result.
template <auto member, typename Read>
auto nested_at(Field field, Read read) {
    if (field.type.empty()) field.type = "object";
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

}  // namespace camrig::world
