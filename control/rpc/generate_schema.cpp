#include <nlohmann/json.hpp>

#include "control/rpc/generated_files.h"
#include "core/base/json_reader.h"
#include "core/world/scene_reader.h"

// The parts of scenes/schema.json that have tables; the forms of values, and what keys demand of each other where no
// kind says it, are written by hand.
namespace camrig::control {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t line_width = 120;

/// As the file is written: what fits a line stands on one.
void print(std::string& out, const ordered_json& value, std::size_t indent, std::size_t column) {
    const std::string flat = [&] {
        std::string text = value.dump();
        if (!value.is_structured()) return text;
        text.clear();
        bool is_first = true;
        for (const auto& [key, item] : value.items()) {
            text += is_first ? "" : ", ";
            is_first = false;
            if (value.is_object()) text += ordered_json(key).dump() + ": ";
            print(text, item, 0, 0);
        }
        return value.is_object() ? "{" + text + "}" : "[" + text + "]";
    }();
    if (column == 0 || !value.is_structured() || column + flat.size() < line_width) {
        out += flat;
        return;
    }
    out += value.is_object() ? "{\n" : "[\n";
    std::size_t left = value.size();
    for (const auto& [key, item] : value.items()) {
        std::string start(indent + 2, ' ');
        if (value.is_object()) start += ordered_json(key).dump() + ": ";
        out += start;
        print(out, item, indent + 2, start.size());
        out += --left > 0 ? ",\n" : "\n";
    }
    out += std::string(indent, ' ') + (value.is_object() ? "}" : "]");
}

/// A whole number without ".0".
ordered_json number_of(double value) {
    if (value == static_cast<double>(static_cast<std::int64_t>(value))) return static_cast<std::int64_t>(value);
    return value;
}

void put_range(ordered_json& schema, const Field& field, const char* low, const char* high) {
    const Range& range = field.range;
    const bool is_number = schema.value("type", "") != "string";
    if (range.has_low()) schema[range.is_low_out && is_number ? "exclusiveMinimum" : low] = number_of(range.low);
    if (range.has_high()) schema[range.is_high_out && is_number ? "exclusiveMaximum" : high] = number_of(range.high);
}

ordered_json schema_of(const Field& field);

/// Adds what holds by default, and what it is in words.
void describe(ordered_json& schema, const Field& field) {
    const auto fallback = ordered_json::parse(field.fallback, nullptr, false);
    const bool is_value = !fallback.is_discarded() || !field.choices.empty() || !field.word.empty();
    if (!field.fallback.empty() && !field.required && field.fallback != "null" && is_value)
        schema["default"] = fallback.is_discarded() ? ordered_json(field.fallback) : fallback;
    std::string words = field.doc.starts_with("see ") ? "" : field.doc;
    if (!words.empty() && !field.unit.empty()) words += ", " + field.unit;
    if (!words.empty()) schema["description"] = std::move(words);
}

ordered_json object_schema(const Field& field) {
    ordered_json properties = ordered_json::object(), required = ordered_json::array();
    for (const Field& part : field.parts) {
        properties[part.name] = schema_of(part);
        if (part.required) required.push_back(part.name);
    }
    ordered_json schema{{"type", "object"}, {"properties", std::move(properties)}, {"additionalProperties", false}};
    if (!required.empty()) schema["required"] = std::move(required);
    return schema;
}

/// null beside what it is otherwise.
ordered_json or_null(const Field& field, ordered_json schema) {
    if (!field.word.empty()) schema = {{"oneOf", ordered_json::array({{{"const", field.word}}, std::move(schema)})}};
    if (!field.is_nullable()) return schema;
    if (schema.contains("enum")) {
        schema["enum"].push_back(nullptr);
        return schema;
    }
    return {{"oneOf", ordered_json::array({{{"type", "null"}}, std::move(schema)})}};
}

ordered_json schema_of(const Field& field) {
    ordered_json schema;
    if (!field.schema.empty()) {
        schema = ordered_json::parse(field.schema);
        if (schema.contains("$ref")) describe(schema, field);
        return schema;
    }
    if (!field.choices.empty()) {
        schema["enum"] = field.choices;
    } else if (field.type.starts_with("object")) {
        schema = object_schema(field);
    } else if (field.type == "array of objects") {
        schema = {{"type", "array"}, {"items", object_schema(field)}};
        put_range(schema, field, "minItems", "maxItems");
    } else if (field.type == "array of numbers") {
        schema = {{"type", "array"}, {"items", {{"type", "number"}}}};
    } else {
        schema["type"] = field.plain_type();
        put_range(schema, field, field.type.starts_with("string") ? "minLength" : "minimum",
                  field.type.starts_with("string") ? "maxLength" : "maximum");
    }
    schema = or_null(field, std::move(schema));
    describe(schema, field);
    return schema;
}

/// A scene that stands on another: any part of what a scene has, whose values are seen together with the base's only.
ordered_json differences_schema() {
    ordered_json schema = object_schema({.parts = descriptions_of<world::Scene>()});
    for (const auto& [key, value] : schema["properties"].items())
        if (value.value("type", "") != "string" && !value.contains("const")) value = ordered_json::object();
    schema["required"].push_back("base");
    return schema;
}

/// Beside the properties that name the kind, one alternative each.
ordered_json alternatives(const KindsDescription& described) {
    ordered_json all = ordered_json::array();
    for (const KindDescription& kind : described.kinds) {
        ordered_json one = object_schema({.parts = kind.fields});
        if (!described.key.empty()) {
            ordered_json properties{{described.key, {{"const", kind.name}}}};
            properties.update(one["properties"]);
            one["properties"] = std::move(properties);
            ordered_json required = ordered_json::array({described.key});
            if (one.contains("required"))
                required.insert(required.end(), one["required"].begin(), one["required"].end());
            one["required"] = std::move(required);
        }
        if (described.name == "behaviour") one["properties"]["until"] = {{"$ref", "#/$defs/until"}};
        if (!kind.rule.empty()) one.update(ordered_json::parse(kind.rule));
        all.push_back(std::move(one));
    }
    return all;
}

}  // namespace

Result<std::string> scene_schema(const std::string& present) {
    ordered_json schema = ordered_json::parse(present, nullptr, false);
    if (schema.is_discarded() || !schema.contains("$defs"))
        return error(ErrorKind::invalid_argument, "is not a JSON schema with $defs");
    const auto part_of = [&](const std::string& name) -> ordered_json& { return schema["$defs"][name]; };
    ordered_json properties = ordered_json::object();
    for (const Field& field : camera_descriptions()) {
        properties[field.name] =
            field.by == Field::By::rig
                ? ordered_json{{"type", field.type}, {"description", "As camera.get answers; does nothing."}}
                : schema_of(field);
        if (field.name != "lens") continue;
        for (const Field& part : field.parts)
            if (schema["$defs"].contains("lens_" + part.name)) part_of("lens_" + part.name) = schema_of(part);
    }
    part_of("camera")["properties"] = std::move(properties);
    for (const auto& [name, fields] : objects_of_scenes()) part_of(name).update(object_schema({.parts = fields}));
    part_of("differences") = differences_schema();
    for (const KindsDescription& described : kinds_of_scenes())
        part_of(described.name)["oneOf"] = alternatives(described);
    std::string text;
    print(text, schema, 0, 1);
    return text + "\n";
}

}  // namespace camrig::control
