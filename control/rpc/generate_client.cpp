#include <array>

#include "control/rpc/generated_files.h"

// control/client/camrig/parameters.h: the parameters of a camera and the state of the world as structs of C++17.
namespace camrig::control {
namespace {

constexpr std::string_view client_head = R"h(#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

)h"
                                         "#include <camrig/values.h>\n"
                                         R"h(
// Made from the rig's own tables by: camrig methods --write . -- changes here are lost.
// clang-format off

/// What a camera is made of, and what the world is doing. Units are SI; degrees where a name ends in _deg. The world is
/// right-handed, z up, in metres; a camera's body frame has x forward, y left, z up. The rig checks all values, not this
/// library. each_member calls visit("name", member).
namespace camrig::client {
)h";

/// Of a JSON type; a string for null is empty.
std::string plain_type(const Field& field) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 12> types{
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
         {"array of strings", "std::vector<std::string>"}}};
    const std::string wanted = field.plain_type();
    if (wanted == "integer" && field.range.has_high() && field.range.high < 1e9) return "int";
    if (wanted == "integer" && field.range.has_low() && field.range.low >= 0 && !field.range.has_high())
        return "std::uint64_t";
    if (wanted == "number" && !field.word.empty()) return "NumberOrAuto";
    if (wanted == "object") return field.shape;
    if (wanted == "array of objects") return "std::vector<" + field.shape + ">";
    for (const auto& [name, type] : types)
        if (name == wanted) return std::string(type);
    CHECK(false);
    return "";
}

enum class Role { told, given, part };

std::string member_of(const Field& field, Role role, bool is_whole) {
    std::string type = plain_type(field), value = "{}";
    const bool is_object_or_null = field.is_nullable() && !field.shape.empty();
    // One that is given as a whole is null when it is empty, as a Mount without an actor.
    if (is_object_or_null && !(role == Role::given && field.is_whole)) type = "std::optional<" + type + ">";
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
    if (field.is_nullable() && !is_object_or_null) doc += ", here empty";
    return "    " + type + " " + field.name + " = " + value + ";" + (doc.empty() ? "" : "  ///< " + doc) + "\n";
}

void put_struct(std::string& out, const std::string& name, const std::string& doc, const std::vector<Field>& fields,
                Role role, bool is_whole, const std::string& more = "") {
    out += "\n/// " + doc + "\nstruct " + name + " {\n";
    for (const Field& field : fields) out += member_of(field, role, is_whole);
    out += more +
           "\n    template <typename Self, typename Visit>\n    static void each_member(Self& self, Visit&& visit) {\n";
    for (const Field& field : fields) out += "        visit(\"" + field.name + "\", self." + field.name + ");\n";
    out += "    }\n};\n";
}

}  // namespace

std::string client_parameters() {
    const std::vector<Field> fields = camera_descriptions();
    std::string out(client_head);
    for (const Field& shape : shapes_in(fields)) {
        std::vector<Field> parts = shape.parts;
        std::erase_if(parts, [](const Field& part) { return part.by == Field::By::client; });
        put_struct(out, shape.shape, "Of a camera: " + shape.name + ".", parts, Role::part, shape.is_whole);
    }
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
