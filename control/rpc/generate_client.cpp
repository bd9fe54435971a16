#include <algorithm>
#include <array>
#include <initializer_list>

#include "control/rpc/generated_files.h"
#include "control/rpc/rpc_server.h"

// control/client/camrig/parameters.h: what methods take and answer as structs of C++17.
namespace camrig::control {
namespace {

constexpr std::string_view client_head = R"h(#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

)h"
                                         "#include <camrig/values.h>\n#include <nlohmann/json.hpp>\n"
                                         R"h(
// Made from the rig's own tables by: camrig methods --write . -- changes here are lost.
// clang-format off

/// What a camera is made of, and what the world and the things in it do. Units are SI; degrees where a name ends in
/// _deg. The world is right-handed, z up, in metres; a camera's body frame has x forward, y left, z up. The rig checks
/// all values, not this library. each_member calls visit("name", member). Null is asked for by an inner optional that
/// is empty: options.mount.emplace(). What comes in kinds with keys of their own (behaviours, triggers, actions, params
/// of faults) is JSON.
namespace camrig::client {
)h";

/// Of a JSON type; a string for null is empty.
std::string plain_type(const Field& field) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 14> types{
        {{"boolean", "bool"},
         {"integer", "std::int64_t"},
         {"number", "double"},
         {"string", "std::string"},
         {"[width, height]", "Size"},
         {"[x, y]", "Vector2"},
         {"array of [x, y]", "std::vector<Vector2>"},
         {"[x, y, z]", "Vector3"},
         {"[x, y, z, w]", "Quaternion"},
         {"number or \"num/den\"", "Rate"},
         {"array of numbers", "std::vector<double>"},
         {"array of strings", "std::vector<std::string>"},
         {"array", "nlohmann::json"},
         {"any", "nlohmann::json"}}};
    const std::string wanted = field.plain_type();
    if (wanted == "integer" && field.range.has_high() && field.range.high < 1e9) return "int";
    if (wanted == "integer" && field.range.has_low() && field.range.low >= 0 && !field.range.has_high())
        return "std::uint64_t";
    if (wanted == "number" && !field.word.empty()) return "NumberOrAuto";
    // An object without parts of its own comes in kinds.
    if (wanted.ends_with("object") && field.parts.empty()) return "nlohmann::json";
    if (wanted == "object") return field.shape;
    if (wanted == "array of objects") return "std::vector<" + field.shape + ">";
    for (const auto& [name, type] : types)
        if (name == wanted) return std::string(type);
    CHECK(false);
    return "";
}

enum class Role { told, given, part };

/// The name of the member: `class` is a word of C++.
std::string member_name(const Field& field) {
    return field.name == "class" ? "object_class" : field.name;
}

std::string member_of(const Field& field, Role role, bool is_whole) {
    std::string type = plain_type(field), value = "{}";
    // Texts are null when they are empty. Of what is given, the inner optional that is empty is null.
    const bool is_object_or_null = field.is_nullable() && !field.shape.empty();
    const bool is_told_or_null = field.is_nullable() && role == Role::told && type != "std::string";
    if (is_object_or_null || is_told_or_null) type = "std::optional<" + type + ">";
    if (role == Role::given || (role == Role::part && !is_whole && !field.required)) {
        type = "std::optional<" + type + ">";
    } else if (type == "std::string" && role == Role::part && (!field.fallback.empty() || !field.choices.empty()) &&
               is_whole) {
        const std::string& first = field.fallback.empty() ? field.choices.front() : field.fallback;
        if (first != "\"\"") value = "\"" + first + "\"";
    } else if (type == "double" || type == "std::int64_t" || type == "int") {
        value = field.fallback.empty() ? "0" : field.fallback;
    } else if (type == "Quaternion") {
        value = "{0, 0, 0, 1}";
    }
    std::string doc = field.doc_text();
    if (!field.unit.empty()) doc = field.unit + (doc.empty() ? "" : "; ") + doc;
    if (field.is_nullable() && !is_object_or_null && !is_told_or_null) doc += ", here empty";
    return "    " + type + " " + member_name(field) + " = " + value + ";" + (doc.empty() ? "" : "  ///< " + doc) + "\n";
}

void put_struct(std::string& out, const std::string& name, const std::string& doc, const std::vector<Field>& fields,
                Role role, bool is_whole, const std::string& more = "") {
    out += "\n/// " + doc + "\nstruct " + name + " {\n";
    for (const Field& field : fields) out += member_of(field, role, is_whole);
    if (role == Role::told)
        out += "\n    /// The rig tells all of them.\n    static constexpr bool is_answer = true;\n";
    out += more +
           "\n    template <typename Self, typename Visit>\n    static void each_member(Self& self, Visit&& visit) {\n";
    for (const Field& field : fields)
        out += "        visit(\"" + field.name + "\", self." + member_name(field) + ");\n";
    out += "    }\n};\n";
}

void put_shapes(std::string& out, const std::string& of, const std::vector<Field>& fields, Role role = Role::part) {
    for (const Field& shape : shapes_in(fields)) {
        std::vector<Field> parts = shape.parts;
        std::erase_if(parts, [](const Field& part) { return part.by == Field::By::client; });
        if (!parts.empty())
            put_struct(out, shape.shape, "Of " + of + ": " + shape.name + ".", parts, role, shape.is_whole);
    }
}

std::vector<Field> without(std::vector<Field> fields, std::initializer_list<std::string_view> names) {
    std::erase_if(fields, [&](const Field& field) { return std::ranges::find(names, field.name) != names.end(); });
    return fields;
}

/// Actors, objects, events and faults: what their methods take beside the names that functions of Rig take, and answer
/// beside applied_ns.
void put_things(std::string& out) {
    const auto params = [](std::string_view method) { return documented_method(method).params; };
    const auto result = [](std::string_view method) {
        return without(documented_method(method).result, {"applied_ns"});
    };
    put_shapes(out, "an actor", params("actor.spawn"));
    put_shapes(out, "an object", result("object.get"), Role::told);
    put_shapes(out, "a log", result("event.wait"), Role::told);
    struct Given {
        const char *name, *doc, *method;
    };
    for (const Given& each :
         {Given{"ActorOptions", "What Rig::spawn_actor takes.", "actor.spawn"},
          Given{"ActorChanges", "What Rig::set_actor takes; what is left out stays.", "actor.set"},
          Given{"ObjectOptions", "What Rig::spawn_object takes.", "object.spawn"},
          Given{"ObjectChanges", "What Rig::set_object takes; what is left out stays.", "object.set"},
          Given{"FaultOptions", "What Rig::set_fault takes.", "fault.set"}}) {
        const bool is_fault = each.method == std::string_view("fault.set");
        const bool is_change = std::string_view(each.method).ends_with(".set") && !is_fault;
        const auto given = is_fault    ? without(params(each.method), {"camera", "kind"})
                           : is_change ? without(params(each.method), {"name"})
                                       : without(params(each.method), {"name", "model"});
        put_struct(out, each.name, each.doc, given, Role::given, false);
    }
    put_struct(out, "Steering", "What Rig::steer_actors takes of each actor.", params("actor.steer").front().parts,
               Role::part, false);
    put_struct(out, "ActorState", "An actor at the world's last step.", result("actor.set"), Role::told, false);
    put_struct(out, "ObjectState", "An object or actor at the world's last step.", result("object.set"), Role::told,
               false);
    put_struct(out, "ObjectInfo", "One of them, with its box.", result("object.get"), Role::told, false);
    put_struct(out, "EventState", "An event that waits.", result("event.add"), Role::told, false);
    put_struct(out, "EventLog", "What has fired.", result("event.wait"), Role::told, false);
    put_struct(out, "FaultState", "A fault of a camera.", result("fault.set"), Role::told, false);
    put_shapes(out, "a log of readers", result("fault.log"), Role::told);
    put_struct(out, "ReaderLog", "What faults let readers meet.", result("fault.log"), Role::told, false);
}

}  // namespace

std::string client_parameters() {
    const std::vector<Field> fields = camera_descriptions();
    std::string out(client_head);
    put_shapes(out, "a camera", fields);
    std::vector<Field> options, state;
    std::string copies;
    for (const Field& field : fields) {
        if (field.by != Field::By::client) state.push_back(field);
        if (field.by == Field::By::rig || field.name == "name") continue;
        if (field.name == "pose") {
            options.insert(options.end(), field.parts.begin(), field.parts.end());
            copies += "    options.position = pose.position;\n    options.orientation = pose.orientation;\n";
            continue;
        }
        options.push_back(field);
        // The intrinsics say the fields of view; of an output there is one only.
        const bool is_copied =
            field.by == Field::By::both && !field.name.ends_with("fov_deg") && field.name != "outputs";
        if (is_copied) copies += "    options." + field.name + " = " + field.name + ";\n";
    }
    put_struct(
        out, "CameraOptions",
        "What a camera can be given. What is left out has the rig's default in create_camera and stays as it is in "
        "Camera::set.",
        options, Role::given, false);
    put_struct(out, "CameraState", "Everything about a camera at one time.", state, Role::told, false,
               "\n    /// Makes the same camera again, without its outputs: a device number can be had once.\n"
               "    CameraOptions options() const;\n");
    put_struct(out, "WorldStatus", "What the world is doing. Times are since the scene was loaded.",
               world_descriptions(), Role::told, false);
    put_things(out);
    out +=
        "\n/// Texts that are null in the protocol where they are empty here.\ninline constexpr const char* "
        "null_when_empty[] = {";
    for (const Field& option : options)
        if (option.is_nullable() && option.shape.empty()) out += "\"" + option.name + "\", ";
    out += "};\n";
    out += "\ninline CameraOptions CameraState::options() const {\n    CameraOptions options;\n" + copies +
           "    return options;\n}\n\n}  // namespace camrig::client\n";
    return out;
}

}  // namespace camrig::control
