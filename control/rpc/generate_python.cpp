#include <algorithm>
#include <array>
#include <utility>

#include "control/rpc/generated_files.h"
#include "core/world/read/actor_json.h"

// control/python/camrig/parameters.py: what editors and type checkers know of the rig's parameters.
namespace camrig::control {
namespace {

constexpr std::string_view python_head =
    R"py("""The parameters of cameras, actors and events, for editors and type checkers.

Made from the rig's own tables by: camrig methods --write . -- changes here are lost.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any, Literal, TypedDict, Union

import numpy as np

Rate = Union[int, float, str, Fraction]
Vector = Union[Sequence[float], np.ndarray]
)py";

/// Of a JSON type; what is given may be wider than what is told.
std::string python_type(const Field& field, bool is_given) {
    struct Type {
        std::string_view json, given, told;
    };
    constexpr std::array types = {Type{"boolean", "bool", "bool"},
                                  Type{"integer", "int", "int"},
                                  Type{"number", "float", "float"},
                                  Type{"string", "str", "str"},
                                  Type{"[width, height]", "Sequence[int]", "list[int]"},
                                  Type{"[x, y]", "Vector", "list[float]"},
                                  Type{"array of [x, y]", "Sequence[Vector]", "list[list[float]]"},
                                  Type{"[x, y, z]", "Vector", "list[float]"},
                                  Type{"[r, g, b]", "Vector", "list[float]"},
                                  Type{"[string, string]", "Sequence[str]", "list[str]"},
                                  Type{"any", "Any", "Any"},
                                  Type{"[x, y, z, w]", "Vector", "list[float]"},
                                  Type{"number or \"num/den\"", "Rate", "Union[int, str]"},
                                  Type{"array of numbers", "Vector", "list[float]"}};
    const std::string wanted = field.plain_type();
    std::string text;
    if (!field.choices.empty()) {
        for (const std::string& choice : field.choices) text += (text.empty() ? "\"" : ", \"") + choice + "\"";
        text = "Literal[" + text + "]";
    } else if (field.shape.empty() && wanted == "object") {
        text = "Mapping[str, Any]";
    } else if (field.shape.empty() && wanted == "array of objects") {
        text = "Sequence[Mapping[str, Any]]";
    } else if (wanted == "object") {
        text = field.shape;
        // Shorter ways to say it: camrig.spec.
        if (is_given && field.shape == "Intrinsics") text = "Union[Intrinsics, Sequence[Sequence[float]], np.ndarray]";
        if (is_given && field.shape == "Mount") text = "Union[Mount, str]";
        if (is_given && field.shape == "Lens") text = "Union[Lens, str, tuple[str, Vector]]";
    } else if (wanted == "array of objects") {
        text = is_given ? "Iterable[Union[" + field.shape + ", str]]" : "list[" + field.shape + "]";
    }
    for (const Type& type : types)
        if (text.empty() && type.json == wanted) text = is_given ? type.given : type.told;
    CHECK(!text.empty());
    if (!field.word.empty()) text = "Union[" + text + ", Literal[\"" + field.word + "\"]]";
    return field.is_nullable() ? "Union[" + text + ", None]" : text;
}

void put_member(std::string& out, const Field& field, bool is_given) {
    out += "    " + field.name + ": " + python_type(field, is_given) + "\n";
    std::string doc = field.doc_text();
    if (!field.unit.empty()) doc = field.unit + (doc.empty() ? "" : "; ") + doc;
    if (is_given && !field.fallback.empty()) doc += (doc.empty() ? "default " : "; default ") + field.fallback;
    if (!doc.empty()) out += "    \"\"\"" + doc + "\"\"\"\n";
}

void put_class(std::string& out, const std::string& name, const std::string& doc, const std::vector<Field>& fields,
               bool is_given, bool is_total) {
    out +=
        "\n\nclass " + name + "(TypedDict" + (is_total ? "" : ", total=False") + "):\n    \"\"\"" + doc + "\"\"\"\n\n";
    for (const Field& field : fields) put_member(out, field, is_given);
}

/// "go_to" as "GoTo".
std::string camel(const std::string& name) {
    std::string text;
    bool is_start = true;
    for (const char c : name) {
        if (c != '_') text += is_start && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
        is_start = c == '_';
    }
    return text;
}

/// A dictionary whose keys may be words of Python, as `class`.
void put_dictionary(std::string& out, const std::string& name, const std::vector<Field>& fields,
                    const std::string& first = {}) {
    out += name + " = TypedDict(\"" + name + "\", {" + first;
    for (std::size_t i = 0; i < fields.size(); ++i)
        out += (i > 0 || !first.empty() ? ", \"" : "\"") + fields[i].name + "\": " + python_type(fields[i], true);
    out += "}, total=False)\n";
}

/// Each kind is a dictionary, and any of them is the name of all.
void put_kinds(std::string& out, const KindsDescription& described) {
    std::string all;
    for (const KindDescription& kind : described.kinds) {
        const std::string name = camel(kind.name) + camel(described.name);
        put_dictionary(out, name, kind.fields,
                       described.key.empty() ? "" : "\"" + described.key + "\": Literal[\"" + kind.name + "\"]");
        all += (all.empty() ? "" : ", ") + name;
    }
    out += camel(described.name) + " = Union[" + all + "]\n";
}

/// Of actors: what Rig.spawn_actor and Rig.set_actor take beside a name.
void put_actors(std::string& out) {
    const auto without = [](std::vector<Field> fields, std::initializer_list<std::string_view> names) {
        std::erase_if(fields, [&](const Field& field) { return std::ranges::find(names, field.name) != names.end(); });
        return fields;
    };
    auto spawned = without(descriptions_of<world::ActorSpec>(), {"name", "model"});
    for (Field& field : spawned)
        if (field.name == "class") field.name = "object_class";
    put_class(out, "ActorOptions", "What Rig.spawn_actor takes.", spawned, true, false);
    put_class(out, "ActorChanges", "What Rig.set_actor takes; what is left out stays as it is.",
              without(descriptions_of<world::ActorPatch>(), {"name"}), true, false);
    put_class(out, "Steering", "What Rig.steer takes of each actor.",
              without(descriptions_of<world::SteerSpec>(), {"name"}), true, false);
}

/// The options as keywords have them: the parts of the pose stand by themselves.
std::vector<Field> options_of(const std::vector<Field>& fields) {
    std::vector<Field> options;
    for (const Field& field : fields) {
        if (field.by != Field::By::both || field.name == "name") continue;
        if (field.name != "pose") {
            options.push_back(field);
            continue;
        }
        options.insert(options.end(), field.parts.begin(), field.parts.end());
    }
    return options;
}

}  // namespace

std::string python_parameters() {
    const std::vector<Field> fields = camera_descriptions(), options = options_of(fields);
    std::string out(python_head);
    for (const Field& shape : shapes_in(fields)) {
        std::vector<Field> parts = shape.parts;
        std::erase_if(parts, [](const Field& part) { return part.by == Field::By::client; });
        put_class(out, shape.shape, "Of a camera: " + shape.name + ".", parts, false, false);
    }
    put_class(out, "CameraOptions", "What Rig.create_camera and Camera.set take; what is left out stays as it is.",
              options, true, false);
    std::vector<Field> state = fields;
    std::erase_if(state, [](const Field& field) { return field.by == Field::By::client; });
    put_class(out, "CameraState", "What Camera.get answers.", state, false, true);

    out += "\n\n";
    put_dictionary(out, "Attachment", descriptions_of<world::Attachment>());
    for (const KindsDescription& described : kinds_of_methods())
        if (described.name != "output") put_kinds(out, described);  // Output is above, with the options of all kinds
    put_actors(out);

    out +=
        "\n\n# Each option, its JSON type, and the object of the protocol that it is in.\nCAMERA_OPTIONS: dict[str, "
        "tuple[str, "
        "str]] = {\n";
    for (const Field& option : options) {
        bool is_in_pose = false;
        for (const Field& field : fields)
            for (const Field& part : field.parts) is_in_pose |= field.name == "pose" && part.name == option.name;
        const char quote = option.type.contains('"') ? '\'' : '"';
        out += "    \"" + option.name + "\": (" + quote + option.type + quote + ", \"" + (is_in_pose ? "pose" : "") +
               "\"),\n";
    }
    return out + "}\n";
}

}  // namespace camrig::control
